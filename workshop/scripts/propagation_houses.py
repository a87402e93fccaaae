"""Rule propagation_houses: synthetic houses with a crop of every surface."""

from plan2scene_app.workflow.jobs import job
from plan2scene_workshop.propagation.data import write_training_houses

with job(snakemake.log[0]):
    write_training_houses(
        snakemake.output[0], count=snakemake.params.houses, seed=snakemake.params.seed
    )
