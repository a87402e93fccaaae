"""Rule reference_features: crops -> the features that FID and KID compare with."""

from plan2scene.evaluation.measure import reference_features
from plan2scene.workflow.jobs import job

with job(snakemake.log[0]):
    reference_features(
        snakemake.input.crops,
        snakemake.params.models["features"],
        snakemake.output[0],
        dataset=snakemake.params.dataset,
        house=snakemake.wildcards.house,
    )
