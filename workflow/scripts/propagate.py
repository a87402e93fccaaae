"""Rule propagate: embeddings of observed surfaces -> embeddings of all surfaces."""

from plan2scene.jobs import job
from plan2scene.propagation.stage import propagate_house

with job(snakemake.log[0]):
    propagate_house(
        snakemake.input.scene,
        snakemake.input.surfaces,
        snakemake.output[0],
        house=snakemake.wildcards.house,
        dataset=snakemake.params.dataset,
        propagation_model=snakemake.input.model,
        texture_model=snakemake.input.texture_model,
    )
