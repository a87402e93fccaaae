"""Rule train_texture: textures -> weights of a texture model and their card."""

from pathlib import Path

import torch

from plan2scene.jobs import job
from plan2scene_workshop.texture.run import train_texture
from plan2scene_workshop.texture.settings import TextureSettings
from plan2scene_workshop.training.loop import best_device

checkpoint = Path(snakemake.params.checkpoint)
with job(snakemake.log[0]):
    torch.set_num_threads(snakemake.threads)
    train_texture(
        snakemake.wildcards.model,
        snakemake.input.materials,
        snakemake.output.model,
        snakemake.output.card,
        settings=TextureSettings(**snakemake.params.settings),
        seed=snakemake.params.seed,
        checkpoint=checkpoint,
        device=best_device(),
    )
    checkpoint.unlink(missing_ok=True)
