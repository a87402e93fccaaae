"""Rule ablation_house: a house by method synth with parts of it left out -> metrics."""

from pathlib import Path

from plan2scene.evaluation.ablation import ablate_house
from plan2scene.evaluation.houses import HouseFiles, Models
from plan2scene.jobs import job

with job(snakemake.log[0]):
    ablate_house(
        HouseFiles(
            house=snakemake.wildcards.house,
            dataset=snakemake.params.dataset,
            scene=Path(snakemake.input.scene),
            crops=Path(snakemake.input.crops),
            embeddings=Path(snakemake.input.embeddings),
            library=Path(snakemake.input.library),
        ),
        Models(
            texture=Path(snakemake.input.texture),
            naivesynth=Path(snakemake.input.naivesynth),
            propagation=Path(snakemake.input.propagation),
            features=Path(snakemake.input.features),
            substances=Path(snakemake.input.substances),
        ),
        snakemake.output[0],
        hidden=snakemake.params.hidden,
        seed=snakemake.params.seed,
        size_px=snakemake.params.size_px,
    )
