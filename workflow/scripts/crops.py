"""Rule crops: photos and masks of a house (or ready crops) -> cameras.json, crops.parquet."""

from pathlib import Path

from plan2scene.datasets.assignments import rooms_of_photos
from plan2scene.floorplans.scene_json import read_scene_json
from plan2scene.jobs import job
from plan2scene.photos.crops.candidates import CropSettings
from plan2scene.photos.crops.stage import CropFiles, load_crops, make_crops
from plan2scene.photos.locate.stage import locate_photos, with_found_rooms

with job(snakemake.log[0]):
    name, params = snakemake.wildcards.house, snakemake.params
    house = read_scene_json(snakemake.input.scene, name)
    rooms_of_photo = rooms_of_photos(snakemake.input.assignment or None, house)
    output = snakemake.output
    files = CropFiles(output.crops, output.candidates, output.colours, output.light)
    if params.source == "precomputed":
        rooms_of_photo = with_found_rooms(house, rooms_of_photo, None)
        load_crops(house, rooms_of_photo, params.folder, files, dataset=params.dataset)
    else:
        locate_photos(house, rooms_of_photo, snakemake.input.masks, output.cameras)
        rooms_of_photo = with_found_rooms(house, rooms_of_photo, output.cameras)
        make_crops(
            house,
            rooms_of_photo,
            {photo: Path(params.photo_folder) / photo for photo in rooms_of_photo},
            snakemake.input.masks,
            files,
            dataset=params.dataset,
            seed=params.seed,
            cameras=output.cameras,
            settings=CropSettings(
                sizes_m=tuple(params.metres),
                per_mask=params.per_mask,
                tries=params.tries,
                camera_height_m=params.camera_height_m,
                filter=params.filter,
                colours=params.colours,
            ),
        )
