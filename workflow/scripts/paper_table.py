"""Rule paper_table: metrics of all houses -> the paper's table 1."""

from plan2scene.evaluation.tables import TableRequest, paper_table
from plan2scene_app.study.plots import plot_table
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    table = paper_table(
        snakemake.input.metrics,
        snakemake.input.references,
        snakemake.output.csv,
        snakemake.output.parquet,
        snakemake.output.latex,
        request=TableRequest(
            dataset=snakemake.params.dataset,
            houses=snakemake.params.houses,
            methods=snakemake.params.methods,
            drop=snakemake.params.drop,
            seed=snakemake.params.seed,
        ),
    )
    plot_table(table, snakemake.output.plot)
