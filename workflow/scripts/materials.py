"""Rule materials: crops and embeddings -> observed surfaces, and the materials that they share."""

from plan2scene.propagation.house_materials import find_materials
from plan2scene.textures.observed_surfaces import select_surfaces
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    inputs, output, hidden = snakemake.input, snakemake.output, snakemake.params.hidden
    names = {"house": snakemake.wildcards.house, "dataset": snakemake.params.dataset}
    for photos, surfaces, materials in zip(
        hidden.values(), output.surfaces, output.materials, strict=True
    ):
        select_surfaces(
            inputs.embeddings, inputs.crops, photos, surfaces, **names, threads=snakemake.threads
        )
        find_materials(
            inputs.scene, surfaces, inputs.embeddings, inputs.light, photos, materials, **names
        )
