"""Rule train_propagation: synthetic houses -> propagation weights and their card."""

from plan2scene_workshop.propagation.run import train_propagation
from plan2scene_workshop.propagation.settings import PropagationSettings
from plan2scene_workshop.training.job import training_job

with training_job(snakemake) as run:
    train_propagation(
        snakemake.input.houses,
        snakemake.input.texture_model,
        snakemake.input.naive_model,
        snakemake.output.model,
        snakemake.output.card,
        settings=PropagationSettings(**snakemake.params.settings),
        **run,
    )
