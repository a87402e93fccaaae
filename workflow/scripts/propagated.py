"""Rule propagated: observed surfaces and the plan -> embeddings of all surfaces."""

import torch

from plan2scene.propagation.propagate import propagate_house
from plan2scene.workflow.jobs import job

with job(snakemake.log[0]):
    torch.set_num_threads(snakemake.threads)
    params = snakemake.params
    propagate_house(
        snakemake.input.scene,
        snakemake.input.surfaces,
        snakemake.output[0],
        propagation_model=params.models["propagation"],
        texture_model=params.models["texture"],
        predictor=params.predictor,
        materials=snakemake.input.materials,
        colours=snakemake.input.colours,
        hidden_photos=params.hidden,
        house=snakemake.wildcards.house,
        dataset=params.dataset,
    )
