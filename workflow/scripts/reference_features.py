"""Rule reference_features: every crop of a house -> its features for FID."""

from plan2scene.evaluation.measure import reference_features
from plan2scene.jobs import job

with job(snakemake.log[0]):
    reference_features(
        snakemake.input.crops,
        snakemake.input.model,
        snakemake.output[0],
        dataset=snakemake.params.dataset,
        house=snakemake.wildcards.house,
    )
