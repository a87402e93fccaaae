"""Rule metrics: tiles of a house against its crops -> metrics per surface."""

from plan2scene.jobs import job
from plan2scene.metrics.stage import measure_house

with job(snakemake.log[0]):
    measure_house(
        snakemake.input.textures,
        snakemake.input.crops,
        snakemake.input.model,
        snakemake.output[0],
        dataset=snakemake.params.dataset,
        house=snakemake.wildcards.house,
        method=snakemake.wildcards.method,
        drop=snakemake.wildcards.drop,
        hidden_photos=snakemake.params.hidden,
    )
