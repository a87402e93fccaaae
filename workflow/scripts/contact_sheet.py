"""Rule contact_sheet: masks, planes and crops of a house's photos -> a picture to look at."""

import json
from pathlib import Path

from plan2scene.plans.scene_json import read_scene_json
from plan2scene.stage_json import read_stage_json
from plan2scene_app.contact_sheet.sheet import SheetFiles, write_contact_sheet
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    inputs, params = snakemake.input, snakemake.params
    house = read_scene_json(inputs.scene, snakemake.wildcards.house)
    files = SheetFiles(
        inputs.crops,
        inputs.candidates,
        inputs.planes,
        inputs.get("masks"),
        inputs.get("cameras"),
    )
    write_contact_sheet(
        snakemake.output[0],
        {photo: Path(params.photo_folder) / photo for photo in json.loads(params.names)},
        read_stage_json(inputs.rooms, "photo_rooms", house=house),
        files,
        house=house,
    )
