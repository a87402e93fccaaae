"""Rule table_textures: crops and propagated embeddings -> tiles by every method of the table."""

from pathlib import Path

from plan2scene.textures.house_textures import table_textures
from plan2scene.textures.inputs import HouseFiles, TextureSettings, Visible
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    inputs, params = snakemake.input, snakemake.params
    table_textures(
        HouseFiles.of(inputs, snakemake.wildcards.house),
        {
            drop: Visible(Path(propagated), params.hidden[drop])
            for drop, propagated in zip(params.hidden, inputs.propagated, strict=True)
        },
        params.methods,
        snakemake.output[0],
        models={name: Path(path) for name, path in params.models.items()},
        settings=TextureSettings(params.seed, params.size_px, params.seam_correction),
        images=params.images,
        ready={params.shown: inputs.shown} if inputs.get("shown") else None,
    )
