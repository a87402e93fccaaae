"""Rule residence_index: houses on disk -> data lists, hidden photos, house table."""

from pathlib import Path

from plan2scene_app.workflow.jobs import job
from plan2scene_workshop.homes.residences import write_dataset_index

with job(snakemake.log[0]) as logger:
    params = snakemake.params
    for line in write_dataset_index(
        Path(snakemake.output.table).parent, params.houses, params.seed
    ):
        logger.warning("%s", line)
