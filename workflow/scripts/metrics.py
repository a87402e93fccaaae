"""Rule metrics: tiles by every method of the table, and crops -> metrics of each surface."""

from pathlib import Path

from plan2scene.evaluation.measure import Networks, measure_textures
from plan2scene.workflow.jobs import job

with job(snakemake.log[0]):
    params = snakemake.params
    measure_textures(
        snakemake.input.textures,
        snakemake.input.crops,
        params.hidden,
        params.methods,
        snakemake.output[0],
        networks=Networks(**{name: Path(path) for name, path in params.models.items()}),
        dataset=params.dataset,
        house=snakemake.wildcards.house,
    )
