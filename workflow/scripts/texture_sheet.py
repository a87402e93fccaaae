"""Rule texture_sheet: crops and tiles of all methods of a house -> texture_sheet.png."""

from pathlib import Path

from plan2scene.evaluation.texture_sheet import write_texture_sheet
from plan2scene.jobs import job

with job(snakemake.log[0]):
    compared = Path(snakemake.input.textures) / "0.0"
    write_texture_sheet(
        snakemake.output[0],
        {method: compared / method for method in snakemake.params.methods},
        snakemake.input.crops,
        house=snakemake.wildcards.house,
    )
