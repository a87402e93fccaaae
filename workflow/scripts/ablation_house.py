"""Rule ablation_house: a house by method synth with parts of it left out -> metrics."""

from plan2scene.evaluation.ablation import ablate_house
from plan2scene.evaluation.houses import HouseFiles, Models
from plan2scene.jobs import job

with job(snakemake.log[0]):
    ablate_house(
        HouseFiles.of(snakemake.input, snakemake.wildcards.house, snakemake.params.dataset),
        Models.of(snakemake.input),
        snakemake.output[0],
        hidden=snakemake.params.hidden,
        seed=snakemake.params.seed,
        size_px=snakemake.params.size_px,
    )
