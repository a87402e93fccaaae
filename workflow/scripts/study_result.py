"""Rule study_result: the study's key and answers -> preferences with their intervals."""

from plan2scene_app.study.study import study_result
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    study_result(
        snakemake.input.key,
        snakemake.input.answers,
        snakemake.output.csv,
        snakemake.output.text,
        pairs=snakemake.params.pairs,
    )
