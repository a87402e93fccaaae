"""Rule embeddings: crops of a house -> their embeddings, substances and textureness."""

import torch

from plan2scene.jobs import job
from plan2scene.textures.model.embedding import make_embeddings

with job(snakemake.log[0]):
    torch.set_num_threads(snakemake.threads)
    make_embeddings(
        snakemake.input.crops,
        snakemake.output[0],
        snakemake.input.texture_model,
        snakemake.input.naive_model,
        house=snakemake.wildcards.house,
        dataset=snakemake.params.dataset,
        seed=snakemake.params.seed,
    )
