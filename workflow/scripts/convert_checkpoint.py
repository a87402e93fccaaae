"""Rule convert_checkpoint: a released checkpoint of a network -> our weight file."""

from plan2scene.checkpoints.convert import convert_checkpoint
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    convert_checkpoint(
        snakemake.wildcards.network,
        snakemake.input[0],
        snakemake.output[0],
        substances=snakemake.params.substances,
    )
