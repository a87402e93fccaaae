"""Rule house: plan and textures -> GLB, and scene.json with textures."""

from plan2scene.mesh.build import build_house
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    build_house(
        snakemake.input.scene,
        snakemake.input.textures,
        snakemake.output.glb,
        snakemake.output.scene,
        house_id=snakemake.wildcards.house,
        objects=snakemake.params.objects,
        relief=snakemake.params.relief,
    )
