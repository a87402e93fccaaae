"""Rule surfaces: crops and their embeddings -> the crop and embedding of each observed surface."""

from plan2scene.textures.observed_surfaces import select_surfaces
from plan2scene.workflow.jobs import job

with job(snakemake.log[0]):
    select_surfaces(
        snakemake.input.embeddings,
        snakemake.input.crops,
        snakemake.params.hidden,
        snakemake.output[0],
        house=snakemake.wildcards.house,
        dataset=snakemake.params.dataset,
        threads=snakemake.threads,
    )
