"""Rule sweep_house: a house at every share of hidden photos -> metrics of all methods."""

from pathlib import Path

from plan2scene.evaluation.houses import HouseFiles, Models
from plan2scene.evaluation.sweep import sweep_house
from plan2scene.jobs import job

with job(snakemake.log[0]):
    sweep_house(
        HouseFiles(
            house=snakemake.wildcards.house,
            dataset=snakemake.params.dataset,
            scene=Path(snakemake.input.scene),
            crops=Path(snakemake.input.crops),
            embeddings=Path(snakemake.input.embeddings),
            library=Path(snakemake.input.library),
            crop_pool=Path(snakemake.input.pool) if snakemake.input.get("pool") else None,
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
        seam_correction=snakemake.params.seam_correction,
        seed=snakemake.params.seed,
        size_px=snakemake.params.size_px,
    )
