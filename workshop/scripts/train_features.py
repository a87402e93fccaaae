"""Rule train_features: textures -> weights of the embedded features network and their card."""

from plan2scene_workshop.features.training import FeaturesSettings, train_features
from plan2scene_workshop.training.job import training_job

with training_job(snakemake) as run:
    train_features(
        snakemake.input.materials,
        snakemake.output.model,
        snakemake.output.card,
        settings=FeaturesSettings(**snakemake.params.settings),
        **run,
    )
