"""Rule materials: observed surfaces -> which of them are one material."""

from plan2scene.propagation.house_materials import find_materials
from plan2scene.workflow.jobs import job

with job(snakemake.log[0]):
    find_materials(
        snakemake.input.scene,
        snakemake.input.surfaces,
        snakemake.input.embeddings,
        snakemake.input.light,
        snakemake.params.hidden,
        snakemake.output[0],
        house=snakemake.wildcards.house,
        dataset=snakemake.params.dataset,
    )
