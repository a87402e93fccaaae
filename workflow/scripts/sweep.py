"""Rule sweep: all houses' sweeps -> every metric against the share of hidden photos."""

from plan2scene.evaluation.tables import TableRequest
from plan2scene_app.study.sweep import sweep_table
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    sweep_table(
        snakemake.input.sweeps,
        snakemake.input.references,
        snakemake.output.csv,
        snakemake.output.plot,
        request=TableRequest(
            dataset=snakemake.params.dataset,
            houses=snakemake.params.houses,
            methods=snakemake.params.methods,
            drop="",
            seed=snakemake.params.seed,
            drops=snakemake.params.drops,
        ),
    )
