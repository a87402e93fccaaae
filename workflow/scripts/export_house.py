"""Rule export_house: plan and textures -> the house in another program's file format."""

from plan2scene_app.exports.registry import export_house
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    export_house(
        snakemake.input.scene,
        snakemake.input.textures,
        snakemake.output[0],
        snakemake.wildcards.export,
        house_id=snakemake.wildcards.house,
        objects=snakemake.params.objects,
    )
