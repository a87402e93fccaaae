"""Rule index_page: all houses, the table and the plot -> index.html."""

from plan2scene_app.viewer.index_page import write_index
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    write_index(
        snakemake.output[0],
        scenes=snakemake.input.scenes,
        table=snakemake.input.table,
        plot=snakemake.input.plot,
        dataset=snakemake.params.dataset,
        method=snakemake.params.method,
    )
