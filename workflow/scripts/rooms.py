"""Rule rooms: plan and textures -> each room at eye level, as a picture."""

from plan2scene.workflow.jobs import job
from plan2scene_app.pictures.house_pictures import draw_rooms

with job(snakemake.log[0]):
    draw_rooms(
        snakemake.input.scene,
        snakemake.input.textures,
        snakemake.output[0],
        house_id=snakemake.wildcards.house,
        objects=snakemake.params.objects,
        traced=snakemake.params.traced,
    )
