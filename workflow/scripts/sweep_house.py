"""Rule sweep_house: a house at every share of hidden photos -> metrics of all methods."""

from pathlib import Path

from plan2scene_app.study.evaluated_house import EvaluatedHouse
from plan2scene_app.study.sweep import sweep_house
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    sweep_house(
        EvaluatedHouse.of(snakemake.input, snakemake.wildcards.house, snakemake.params),
        Path(snakemake.input.embeddings),
        snakemake.output[0],
        hidden=snakemake.params.hidden,
        methods=snakemake.params.methods,
    )
