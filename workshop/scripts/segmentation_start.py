"""Rule segmentation_start: drawn rooms -> weights that training on photos starts from."""

from pathlib import Path

import torch

from plan2scene.jobs import job
from plan2scene_workshop.segmentation.run import train_start
from plan2scene_workshop.segmentation.settings import SegmentationSettings

with job(snakemake.log[0]):
    torch.set_num_threads(snakemake.threads)
    train_start(
        snakemake.input[0],
        snakemake.output[0],
        settings=SegmentationSettings(**snakemake.params.settings),
        seed=snakemake.params.seed,
        checkpoint=Path(snakemake.params.checkpoint),
    )
