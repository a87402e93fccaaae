"""Rule contact_sheet: photos, masks and windows of a house -> contact_sheet.png."""

from pathlib import Path

from plan2scene.datasets.assignments import rooms_of_photos
from plan2scene.floorplans.scene_json import read_scene_json
from plan2scene.jobs import job
from plan2scene.photos.contact_sheet.sheet import write_contact_sheet

with job(snakemake.log[0]):
    params = snakemake.params
    house = read_scene_json(snakemake.input.scene, snakemake.wildcards.house)
    write_contact_sheet(
        snakemake.output[0],
        {name: Path(params.photo_folder) / name for name in params.names},
        rooms_of_photos(snakemake.input.assignment or None, house),
        house=house,
        masks_dir=snakemake.input.get("masks"),
        cameras=snakemake.input.get("cameras"),
        crops=snakemake.input.crops,
        candidates=snakemake.input.candidates,
        camera_height_m=params.camera_height_m,
    )
