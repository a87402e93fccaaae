"""Rule study: the sheets of the houses -> the study's form and its key."""

from plan2scene_app.study.study import write_study
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    write_study(
        snakemake.input.sheets,
        snakemake.output.form,
        snakemake.output.key,
        houses=snakemake.params.houses,
        pairs=snakemake.params.pairs,
        seed=snakemake.params.seed,
    )
