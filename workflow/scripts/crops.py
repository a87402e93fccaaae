"""Rule crops: photos, masks and cameras of a house (or ready crops) -> crops.parquet."""

from pathlib import Path

from plan2scene.datasets import read_assignment
from plan2scene.floorplans.scene_json import read_scene_json
from plan2scene.jobs import job
from plan2scene.photos.crops.candidates import CropSettings
from plan2scene.photos.crops.stage import load_crops, make_crops

with job(snakemake.log[0]):
    name, params = snakemake.wildcards.house, snakemake.params
    house = read_scene_json(snakemake.input.scene, name)
    table = snakemake.input.assignment
    rooms_of_photo: dict[str, list[str]] = {}
    for row in read_assignment(table or None, house):
        rooms_of_photo.setdefault(row.photo, []).append(row.room_id)
    output = snakemake.output
    paths = (output.crops, output.candidates, output.light)
    dataset = params.dataset
    if params.source == "precomputed":
        load_crops(house, rooms_of_photo, params.folder, *paths, dataset=dataset)
    else:
        make_crops(
            house,
            rooms_of_photo,
            {photo: Path(params.photo_folder) / photo for photo in rooms_of_photo},
            snakemake.input.masks,
            *paths,
            dataset=dataset,
            seed=params.seed,
            settings=CropSettings(
                metres=tuple(params.metres),
                per_mask=params.per_mask,
                tries=params.tries,
                camera_height_m=params.camera_height_m,
                filter=params.filter,
                white_balance=params.white_balance,
                exposure=params.exposure,
            ),
        )
