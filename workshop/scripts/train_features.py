"""Rule train_features: textures -> weights of the embedded features network and their card."""

from pathlib import Path

import torch

from plan2scene.jobs import job
from plan2scene_workshop.features.settings import FeaturesSettings
from plan2scene_workshop.features.training import train_features
from plan2scene_workshop.training.loop import best_device

checkpoint = Path(snakemake.params.checkpoint)
with job(snakemake.log[0]):
    torch.set_num_threads(snakemake.threads)
    train_features(
        snakemake.input.materials,
        snakemake.output.model,
        snakemake.output.card,
        settings=FeaturesSettings(**snakemake.params.settings),
        seed=snakemake.params.seed,
        checkpoint=checkpoint,
        device=best_device(),
    )
    checkpoint.unlink(missing_ok=True)
