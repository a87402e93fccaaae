"""Rule comparison: a house's crops and embeddings -> textures and metrics of all methods."""

from pathlib import Path

from plan2scene.evaluation.comparison import compare_house
from plan2scene.evaluation.houses import EvaluatedHouse
from plan2scene.jobs import job
from plan2scene.textures.inputs import Visible

with job(snakemake.log[0]):
    found, params = snakemake.input, snakemake.params
    compare_house(
        EvaluatedHouse.of(found, snakemake.wildcards.house, params),
        {
            drop: Visible(Path(propagated), params.hidden[drop])
            for drop, propagated in zip(params.hidden, found.propagated, strict=True)
        },
        params.methods,
        snakemake.output.textures,
        snakemake.output.metrics,
        images=params.images,
    )
