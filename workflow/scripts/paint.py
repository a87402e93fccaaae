"""Rule paint: colours, materials, textures and finishes of a house -> textures in paint."""

from plan2scene.paint.surfaces import write_paint
from plan2scene.textures.painted import paint_textures
from plan2scene.workflow.jobs import job

with job(snakemake.log[0]):
    found, output = snakemake.input, snakemake.output
    write_paint(
        found.colours,
        found.materials,
        output.paint,
        dataset=snakemake.params.dataset,
        house=snakemake.wildcards.house,
    )
    paint_textures(
        found.textures,
        output.paint,
        output.textures,
        finishes=found.get("finishes"),
        crops=found.get("crops"),
    )
