"""Rule train_segmentation: a synthetic data set -> segmentation weights and their card."""

from pathlib import Path

import torch

from plan2scene.jobs import job
from plan2scene_workshop.segmentation.run import train_segmentation
from plan2scene_workshop.segmentation.settings import SegmentationSettings

checkpoint = Path(snakemake.params.checkpoint)
with job(snakemake.log[0]):
    torch.set_num_threads(snakemake.threads)
    train_segmentation(
        Path(snakemake.input.table).parent,
        snakemake.output.model,
        snakemake.output.card,
        settings=SegmentationSettings(**snakemake.params.settings),
        seed=snakemake.params.seed,
        checkpoint=checkpoint,
    )
    checkpoint.unlink(missing_ok=True)
