"""Rule train_texture: textures -> weights of a texture model and their card."""

from plan2scene_workshop.texture.run import train_texture
from plan2scene_workshop.texture.settings import TextureSettings
from plan2scene_workshop.training.job import training_job

with training_job(snakemake) as run:
    train_texture(
        snakemake.wildcards.model,
        snakemake.input.materials,
        snakemake.output.model,
        snakemake.output.card,
        settings=TextureSettings(**snakemake.params.settings),
        **run,
    )
