"""Rule ablation_house: a house, by variants of method synth -> metrics."""

from pathlib import Path

from plan2scene_app.study.ablation import ablate_house
from plan2scene_app.study.evaluated_house import EvaluatedHouse
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    ablate_house(
        EvaluatedHouse.of(snakemake.input, snakemake.wildcards.house, snakemake.params),
        Path(snakemake.input.embeddings),
        snakemake.output[0],
        hidden=snakemake.params.hidden,
    )
