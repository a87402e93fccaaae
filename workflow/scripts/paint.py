"""Rule paint: observed colours and shared materials of a house -> paint of its surfaces."""

from plan2scene.paint.surfaces import write_paint
from plan2scene.workflow.jobs import job

with job(snakemake.log[0]):
    write_paint(
        snakemake.input.colours,
        snakemake.input.materials,
        snakemake.output[0],
        dataset=snakemake.params.dataset,
        house=snakemake.wildcards.house,
    )
