"""Rule masks: photos of a house -> label PNGs, line segments and cameras.json."""

import json
from pathlib import Path

from plan2scene.photos.labels.labeller import labeller
from plan2scene.photos.masks import make_masks
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]) as log:
    params, house_id = snakemake.params, snakemake.wildcards.house
    things = params.find_rooms == "imagenet"
    if things:
        log.info("photos' rooms: told by the things in them, too")
    elif params.find_rooms:
        log.warning("photos' rooms: more are found with the extra 'rooms' (photos.kinds)")
    # All photo names of the house table: the stage reports missing photos and unsafe names.
    make_masks(
        {name: Path(params.photo_folder) / name for name in json.loads(params.names)},
        lambda: labeller(
            params.source,
            model=params.models.get("segmentation"),
            imagenet=params.models.get("segmentation_imagenet"),
            kinds=params.models.get("kinds"),
            amodal=params.models.get("amodal"),
            things=things,
            precomputed_dir=params.masks_folder,
            pretrained=params.pretrained,
            openings=params.openings,
            threads=1,  # several photos are processed at the same time
            house_id=house_id,
        ),
        snakemake.output[0],
        house_id=house_id,
        fov_deg=params.fov_deg,
        known_fov_deg=params.known_fov_deg,
        find_rooms=params.find_rooms,
        threads=snakemake.threads,
    )
