"""Rule masks: photos of a house -> label PNGs and cameras.json."""

from pathlib import Path

from plan2scene.jobs import job
from plan2scene.photos.masks import make_masks

with job(snakemake.log[0]):
    params = snakemake.params
    pretrained = None
    if params.source == "pretrained":
        from plan2scene.photos.labels.pretrained import Checkpoint

        pretrained = Checkpoint(**params.pretrained)
    # All names of the house table: the stage says which photos are missing or unsafe.
    make_masks(
        {name: Path(params.photo_folder) / name for name in params.names},
        snakemake.output[0],
        house_id=snakemake.wildcards.house,
        source=params.source,
        model=snakemake.input.model or None,
        precomputed_dir=params.masks_folder,
        pretrained=pretrained,
        fov_deg=params.fov_deg,
        threads=snakemake.threads,
    )
