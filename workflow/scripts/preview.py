"""Rule preview: plan and textures -> the house from above, as a picture."""

from plan2scene.workflow.jobs import job
from plan2scene_app.pictures.house_pictures import draw_preview

with job(snakemake.log[0]):
    draw_preview(
        snakemake.input.scene,
        snakemake.input.textures,
        snakemake.output[0],
        house_id=snakemake.wildcards.house,
        objects=snakemake.params.objects,
    )
