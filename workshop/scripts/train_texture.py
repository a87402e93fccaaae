"""Rules train_texture and train_naivesynth: textures -> weights and their card."""

from pathlib import Path

import torch

from plan2scene.jobs import job
from plan2scene_workshop.texture.run import TextureData, train_texture
from plan2scene_workshop.texture.settings import TextureTraining

with job(snakemake.log[0]):
    torch.set_num_threads(snakemake.threads)
    train_texture(
        snakemake.params.model,
        TextureData(
            seed=snakemake.params.seed,
            cache=Path(snakemake.params.cache),
            **snakemake.params.data,
        ),
        TextureTraining(**snakemake.params.settings),
        snakemake.output.model,
        snakemake.output.card,
        checkpoint=Path(snakemake.params.checkpoint),
        device="cuda" if torch.cuda.is_available() else "cpu",
    )
