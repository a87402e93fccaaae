"""Rule embeddings: crops of a house -> their embeddings."""

import torch

from plan2scene.textures.model.embedding import make_embeddings
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    torch.set_num_threads(1)  # several crops are processed at the same time
    params = snakemake.params
    make_embeddings(
        snakemake.input.crops,
        snakemake.output[0],
        params.models["texture"],
        params.models["naivesynth"],
        house=snakemake.wildcards.house,
        dataset=params.dataset,
        seed=params.seed,
        threads=snakemake.threads,
    )
