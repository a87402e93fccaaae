"""Rule texture_sheet: crops and tiles of all methods of a house -> texture_sheet.png."""

from plan2scene.evaluation.texture_sheet import write_texture_sheet
from plan2scene.jobs import job

with job(snakemake.log[0]):
    write_texture_sheet(
        snakemake.output[0],
        dict(zip(snakemake.params.methods, snakemake.input.textures, strict=True)),
        snakemake.input.crops,
        [],
        house=snakemake.wildcards.house,
    )
