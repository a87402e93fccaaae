"""Rule crops: photos, masks and places of a house, or precomputed crops -> crop tables."""

from pathlib import Path

from plan2scene.photos.crops.extract_crops import (
    CropFiles,
    crops_of_house,
    read_precomputed_crops,
    write_crops,
)
from plan2scene.photos.crops.sampling import CropSettings
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.stage_json import read_stage_json
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    params, output = snakemake.params, snakemake.output
    house = read_scene_json(snakemake.input.scene, snakemake.wildcards.house)
    rooms = read_stage_json(snakemake.input.rooms, "photo_rooms", house=house)
    masks = snakemake.input.get("masks")
    if masks:
        made = crops_of_house(
            house,
            rooms,
            {photo: Path(params.photo_folder) / photo for photo in rooms},
            masks,
            seed=params.seed,
            settings=CropSettings(**params.settings),
            cameras=snakemake.input.cameras,
            threads=snakemake.threads,
        )
    else:
        made = read_precomputed_crops(house, rooms, params.folder)
    files = CropFiles(output.crops, output.candidates, output.planes, output.colours, output.light)
    write_crops(made, files, dataset=params.dataset, house_id=house.id)
