"""Rule train_kinds: photos of synthetic homes -> weights of the classifier of rooms, card."""

from pathlib import Path

from plan2scene_workshop.kinds.training import KindsSettings, train_kinds
from plan2scene_workshop.training.job import training_job

with training_job(snakemake) as run:
    train_kinds(
        Path(snakemake.input.table).parent,
        snakemake.params.segmentation,
        snakemake.output.model,
        snakemake.output.card,
        settings=KindsSettings(**snakemake.params.settings),
        **run,
    )
