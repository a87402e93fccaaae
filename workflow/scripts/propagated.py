"""Rule propagated: observed surfaces and the plan -> embeddings of all surfaces."""

import torch

from plan2scene.propagation.propagate import propagate_house
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    torch.set_num_threads(snakemake.threads)
    inputs, params = snakemake.input, snakemake.params
    for photos, surfaces, materials, propagated in zip(
        params.hidden.values(), inputs.surfaces, inputs.materials, snakemake.output, strict=True
    ):
        propagate_house(
            inputs.scene,
            surfaces,
            propagated,
            propagation_model=params.models["propagation"],
            texture_model=params.models["texture"],
            predictor=params.predictor,
            materials=materials,
            colours=inputs.colours,
            hidden_photos=photos,
            house=snakemake.wildcards.house,
            dataset=params.dataset,
        )
