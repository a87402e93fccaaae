"""Rule house_obj: plan and textures -> OBJ with MTL and textures."""

from plan2scene.jobs import job
from plan2scene.mesh.build import build_obj

with job(snakemake.log[0]):
    build_obj(
        snakemake.input.scene,
        snakemake.input.textures,
        snakemake.output.obj,
        house_id=snakemake.wildcards.house,
    )
