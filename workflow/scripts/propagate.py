"""Rule propagate: embeddings of observed surfaces -> embeddings of all surfaces."""

from plan2scene.jobs import job
from plan2scene.propagation.stage import propagate_house

with job(snakemake.log[0]):
    for surfaces, output in zip(snakemake.input.surfaces, snakemake.output, strict=True):
        propagate_house(
            snakemake.input.scene,
            surfaces,
            output,
            house=snakemake.wildcards.house,
            dataset=snakemake.params.dataset,
            propagation_model=snakemake.input.model,
            texture_model=snakemake.input.texture_model,
        )
