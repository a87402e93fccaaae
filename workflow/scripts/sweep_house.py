"""Rule sweep_house: a house at every share of hidden photos -> metrics of all methods."""

from plan2scene.evaluation.houses import HouseFiles, Models
from plan2scene.evaluation.sweep import sweep_house
from plan2scene.jobs import job

with job(snakemake.log[0]):
    sweep_house(
        HouseFiles.of(snakemake.input, snakemake.wildcards.house, snakemake.params.dataset),
        Models.of(snakemake.input),
        snakemake.output[0],
        hidden=snakemake.params.hidden,
        seam_correction=snakemake.params.seam_correction,
        seed=snakemake.params.seed,
        size_px=snakemake.params.size_px,
    )
