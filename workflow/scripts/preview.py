"""Rule preview: plan and textures -> the house from above, as a picture."""

from plan2scene.mesh.pictures import draw_preview
from plan2scene.workflow.jobs import job

with job(snakemake.log[0]):
    draw_preview(
        snakemake.input.scene,
        snakemake.input.textures,
        snakemake.output[0],
        house_id=snakemake.wildcards.house,
        objects=snakemake.params.objects,
    )
