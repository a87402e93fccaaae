"""Rule lit_house: plan and textures -> GLB with baked light."""

from plan2scene_app.pictures.lit_house import build_lit_house
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    build_lit_house(
        snakemake.input.scene,
        snakemake.input.textures,
        snakemake.output[0],
        house_id=snakemake.wildcards.house,
        objects=snakemake.params.objects,
    )
