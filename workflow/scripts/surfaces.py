"""Rule surfaces: crops of visible photos -> one chosen embedding per observed surface."""

from plan2scene.jobs import job
from plan2scene.textures.selection import select_surfaces

with job(snakemake.log[0]):
    select_surfaces(
        snakemake.input.embeddings,
        snakemake.input.crops,
        snakemake.params.hidden,
        snakemake.output[0],
        house=snakemake.wildcards.house,
        dataset=snakemake.params.dataset,
    )
