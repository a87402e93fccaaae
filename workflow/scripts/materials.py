"""Rule materials: crops and embeddings -> observed surfaces, and which of them are one material."""

from plan2scene.propagation.house_materials import find_materials
from plan2scene.textures.observed_surfaces import select_surfaces
from plan2scene.workflow.jobs import job

with job(snakemake.log[0]):
    found, output, hidden = snakemake.input, snakemake.output, snakemake.params.hidden
    names = {"house": snakemake.wildcards.house, "dataset": snakemake.params.dataset}
    for photos, surfaces, materials in zip(
        hidden.values(), output.surfaces, output.materials, strict=True
    ):
        select_surfaces(
            found.embeddings, found.crops, photos, surfaces, **names, threads=snakemake.threads
        )
        find_materials(
            found.scene, surfaces, found.embeddings, found.light, photos, materials, **names
        )
