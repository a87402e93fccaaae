"""Rule crops: photos and masks of a house (or ready crops) -> places, crops, contact sheet."""

from pathlib import Path

from plan2scene.datasets.assignments import rooms_of_photos
from plan2scene.photos.contact_sheet.sheet import write_contact_sheet
from plan2scene.photos.crops.candidates import CropSettings
from plan2scene.photos.crops.stage import CropFiles, load_crops, make_crops
from plan2scene.photos.locate.stage import locate_photos, with_found_rooms
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.workflow.jobs import job

with job(snakemake.log[0]):
    name, params, output = snakemake.wildcards.house, snakemake.params, snakemake.output
    masks, cameras = snakemake.input.get("masks"), output.get("cameras")
    house = read_scene_json(snakemake.input.scene, name)
    listed = rooms_of_photos(snakemake.input.assignment or None, house)
    if masks:
        locate_photos(house, listed, masks, cameras, threads=snakemake.threads)
    rooms = with_found_rooms(house, listed, cameras)
    files = CropFiles(output.crops, output.candidates, output.colours, output.light)
    folder, settings = Path(params.photo_folder), CropSettings(**params.settings)
    if masks:
        photos = {photo: folder / photo for photo in rooms}
        made = {"dataset": params.dataset, "seed": params.seed, "settings": settings}
        made |= {"cameras": cameras, "threads": snakemake.threads}
        make_crops(house, rooms, photos, masks, files, **made)
    else:
        load_crops(house, rooms, params.folder, files, dataset=params.dataset)
    write_contact_sheet(
        output.sheet,
        {photo: folder / photo for photo in params.names},
        listed,
        house=house,
        masks_dir=masks,
        cameras=cameras,
        crops=output.crops,
        candidates=output.candidates,
        camera_height_m=settings.camera_height_m,
        threads=snakemake.threads,
    )
