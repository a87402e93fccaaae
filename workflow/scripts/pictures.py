"""Rule pictures: plan and textures -> the house from above and its rooms, as pictures."""

from plan2scene.workflow.jobs import job
from plan2scene_app.pictures.house_pictures import draw_house

with job(snakemake.log[0]):
    draw_house(
        snakemake.input.scene,
        snakemake.input.textures,
        snakemake.output.preview,
        snakemake.output.rooms,
        house_id=snakemake.wildcards.house,
        objects=snakemake.params.objects,
        traced=snakemake.params.traced,
    )
