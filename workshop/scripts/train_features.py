"""Rule train_features: materials -> weights of the embedded features network and their card."""

import torch

from plan2scene.jobs import job
from plan2scene_workshop.features.training import FeaturesTraining, train_features

with job(snakemake.log[0]):
    torch.set_num_threads(snakemake.threads)
    train_features(
        snakemake.output.model,
        snakemake.output.card,
        settings=FeaturesTraining(**snakemake.params.settings),
    )
