"""Rule house: plan and textures -> GLB, scene.json with textures, preview."""

from plan2scene.jobs import job
from plan2scene.mesh.build import build_house

with job(snakemake.log[0]):
    build_house(
        snakemake.input.scene,
        snakemake.input.textures,
        snakemake.output.glb,
        snakemake.output.scene,
        snakemake.output.preview,
        house_id=snakemake.wildcards.house,
    )
