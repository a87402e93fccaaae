"""Rule comparison: a house's crops and embeddings -> textures and metrics of all methods."""

from pathlib import Path

from plan2scene.evaluation.comparison import compare_house
from plan2scene.evaluation.houses import EvaluatedHouse
from plan2scene.evaluation.measure import reference_features
from plan2scene.evaluation.texture_sheet import write_texture_sheet
from plan2scene.textures.inputs import Visible
from plan2scene.workflow.jobs import job

with job(snakemake.log[0]):
    found, made, params = snakemake.input, snakemake.output, snakemake.params
    house_id = snakemake.wildcards.house
    compare_house(
        EvaluatedHouse.of(found, house_id, params),
        {
            drop: Visible(Path(propagated), params.hidden[drop])
            for drop, propagated in zip(params.hidden, found.propagated, strict=True)
        },
        params.methods,
        made.textures,
        made.metrics,
        images=params.images,
        ready={params.shown: found.shown} if found.get("shown") else None,
    )
    names = {"dataset": params.dataset, "house": house_id}
    reference_features(found.crops, params.models["features"], made.references, **names)
    compared = {method: Path(made.textures) / "0.0" / method for method in params.methods}
    write_texture_sheet(made.sheet, compared, found.crops, house=house_id)
