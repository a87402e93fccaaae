"""Rule painted_textures: textures in the photos' colours and paint -> textures in paint."""

from plan2scene.textures.painted import paint_textures
from plan2scene.workflow.jobs import job

with job(snakemake.log[0]):
    paint_textures(snakemake.input.textures, snakemake.input.paint, snakemake.output[0])
