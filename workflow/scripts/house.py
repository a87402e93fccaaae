"""Rule house: plan and textures -> GLB, scene.json with textures, pictures, offline viewer."""

from plan2scene.jobs import job
from plan2scene.mesh.build import build_house
from plan2scene.viewer import build_viewer

with job(snakemake.log[0]):
    house_id, made = snakemake.wildcards.house, snakemake.output
    build_house(
        snakemake.input.scene,
        snakemake.input.textures,
        made.glb,
        made.scene,
        made.preview,
        made.rooms,
        house_id=house_id,
    )
    build_viewer(made.glb, made.viewer, house_id=house_id)
