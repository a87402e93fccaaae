"""Rule surfaces: crops of visible photos -> one chosen embedding per observed surface."""

from plan2scene.jobs import job
from plan2scene.textures.selection import select_surfaces

with job(snakemake.log[0]):
    hidden = snakemake.params.hidden
    for drop, output in zip(hidden, snakemake.output, strict=True):
        select_surfaces(
            snakemake.input.embeddings,
            snakemake.input.crops,
            hidden[drop],
            output,
            house=snakemake.wildcards.house,
            dataset=snakemake.params.dataset,
        )
