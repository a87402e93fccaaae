"""Rule train_propagation: synthetic houses -> propagation weights and their card."""

import torch

from plan2scene.jobs import job
from plan2scene_workshop.propagation.run import train_propagation
from plan2scene_workshop.propagation.settings import PropagationSettings

with job(snakemake.log[0]):
    torch.set_num_threads(snakemake.threads)
    train_propagation(
        snakemake.input.houses,
        snakemake.input.texture_model,
        snakemake.input.naive_model,
        snakemake.output.model,
        snakemake.output.card,
        settings=PropagationSettings(**snakemake.params.settings),
        seed=snakemake.params.seed,
    )
