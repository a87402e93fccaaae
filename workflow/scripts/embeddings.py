"""Rule embeddings: crops of a house -> embeddings of crops, of observed and of all surfaces."""

import torch

from plan2scene.propagation.house_materials import find_materials
from plan2scene.propagation.stage import propagate_house
from plan2scene.textures.model.embedding import make_embeddings
from plan2scene.textures.selection import select_surfaces
from plan2scene.workflow.jobs import job

with job(snakemake.log[0]):
    torch.set_num_threads(1)  # crops are worked on beside each other
    found, made, params = snakemake.input, snakemake.output, snakemake.params
    models = params.models
    threads = {"threads": snakemake.threads}
    names = {"house": snakemake.wildcards.house, "dataset": params.dataset}
    make_embeddings(
        found.crops,
        made.embeddings,
        models["texture"],
        models["naivesynth"],
        seed=params.seed,
        **threads,
        **names,
    )
    tables = (made.surfaces, made.materials, made.propagated)
    for hidden, surfaces, materials, propagated in zip(
        params.hidden.values(), *tables, strict=True
    ):
        select_surfaces(made.embeddings, found.crops, hidden, surfaces, **threads, **names)
        find_materials(
            found.scene, surfaces, made.embeddings, found.light, hidden, materials, **names
        )
        propagate_house(
            found.scene,
            surfaces,
            propagated,
            propagation_model=models["propagation"],
            texture_model=models["texture"],
            predictor=params.predictor,
            materials=materials,
            colours=found.colours,
            hidden_photos=hidden,
            **names,
        )
