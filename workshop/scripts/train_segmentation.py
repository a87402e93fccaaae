"""Rule train_segmentation: a synthetic data set -> segmentation weights and their card."""

from pathlib import Path

from plan2scene.jobs import job
from plan2scene_workshop.segmentation.training import train_segmentation

with job(snakemake.log[0]):
    train_segmentation(
        Path(snakemake.input.table).parent,
        snakemake.input.scenes,
        snakemake.input.start,
        snakemake.output.model,
        snakemake.output.card,
        settings=snakemake.params.settings,
        seed=snakemake.params.seed,
        threads=snakemake.threads,
    )
