"""Rule train_segmentation: a synthetic data set -> segmentation weights and their card."""

from pathlib import Path

from plan2scene_workshop.segmentation.run import train_segmentation
from plan2scene_workshop.segmentation.settings import SegmentationSettings
from plan2scene_workshop.training.job import training_job

with training_job(snakemake) as run:
    train_segmentation(
        Path(snakemake.input.table).parent,
        snakemake.output.model,
        snakemake.output.card,
        settings=SegmentationSettings(**snakemake.params.settings),
        **run,
    )
