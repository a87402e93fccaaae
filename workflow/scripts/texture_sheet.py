"""Rule texture_sheet: crops and tiles by every method -> one picture to look at."""

from pathlib import Path

from plan2scene_app.pictures.texture_sheet import write_texture_sheet
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    folder = Path(snakemake.input.textures) / "0.0"
    write_texture_sheet(
        snakemake.output[0],
        {method: folder / method for method in snakemake.params.methods},
        snakemake.input.crops,
        house=snakemake.wildcards.house,
    )
