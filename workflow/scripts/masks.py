"""Rule masks: photos of a house -> label PNGs and cameras.json."""

from pathlib import Path

from plan2scene.jobs import job
from plan2scene.photos.stage import make_masks

with job(snakemake.log[0]):
    # All names of the house table: the stage says which photos are missing or unsafe.
    make_masks(
        {name: Path(snakemake.params.photo_folder) / name for name in snakemake.params.names},
        snakemake.output[0],
        house=snakemake.wildcards.house,
        source=snakemake.params.source,
        model=snakemake.input.model or None,
        precomputed_dir=snakemake.params.masks_folder,
        fov_deg=snakemake.params.fov_deg,
        threads=snakemake.threads,
    )
