"""Rule metrics: tiles of a house by every method against its crops -> metrics per surface."""

from plan2scene.jobs import job
from plan2scene.metrics.resampling import FurtherSeeds
from plan2scene.metrics.stage import measure_house, read_references

with job(snakemake.log[0]):
    found, params = snakemake.input, snakemake.params
    further = {
        method: FurtherSeeds(
            propagated=found.propagated,
            model=decoder,
            count=params.images,
            seed=params.seed,
            size_px=params.size_px,
            seam_correction=params.seam_correction[method],
        )
        for method, decoder in zip(params.redrawn, found.decoders, strict=True)
    }
    references = read_references(found.crops, params.hidden)
    for method, textures, output in zip(
        params.methods, found.textures, snakemake.output, strict=True
    ):
        measure_house(
            textures,
            references,
            found.model,
            output,
            dataset=params.dataset,
            house=snakemake.wildcards.house,
            method=method,
            drop=snakemake.wildcards.drop,
            substance_model=found.substance_model,
            further=further.get(method),
        )
