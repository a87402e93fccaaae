"""Rule metrics: tiles of a house against its crops -> metrics per surface."""

from plan2scene.jobs import job
from plan2scene.metrics.resampling import FurtherSeeds
from plan2scene.metrics.stage import measure_house

with job(snakemake.log[0]):
    further = None
    if snakemake.input.decoder:
        further = FurtherSeeds(
            propagated=snakemake.input.propagated,
            model=snakemake.input.decoder,
            count=snakemake.params.images,
            seed=snakemake.params.seed,
            size_px=snakemake.params.size_px,
            seam_correction=snakemake.params.seam_correction,
        )
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
        substance_model=snakemake.input.substance_model,
        further=further,
    )
