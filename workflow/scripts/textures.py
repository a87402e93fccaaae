"""Rule textures: propagated embeddings, crops and models -> a tile, and a map, per surface."""

from pathlib import Path

from plan2scene.textures.house_textures import make_textures
from plan2scene.textures.inputs import HouseData, HouseFiles, TextureSettings, Visible
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    inputs, params = snakemake.input, snakemake.params
    own = params.textures  # params of this method, drop fraction and house
    files = HouseFiles.of(inputs, snakemake.wildcards.house)
    house = HouseData(files).at(
        Visible(Path(inputs.propagated), own["hidden"]),
        {name: Path(path) for name, path in own["models"].items()},
        TextureSettings(params.seed, params.size_px, own["seam_correction"], snakemake.threads),
    )
    make_textures(snakemake.wildcards.method, house, snakemake.output[0], maps=own["maps"])
