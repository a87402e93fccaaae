"""Rule study_house: plan, photos and textures of a house -> its sheet in the user study."""

import json
from pathlib import Path

from plan2scene.datasets.assignments import rooms_of_photos
from plan2scene.plans.scene_json import read_scene_json
from plan2scene_app.study.study_sheet import write_study_sheet
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    house = read_scene_json(snakemake.input.scene, snakemake.wildcards.house)
    files = {
        name: Path(snakemake.params.photo_folder) / name
        for name in json.loads(snakemake.params.names)
    }
    params, inputs = snakemake.params, snakemake.input
    made = dict(zip(params.others, map(Path, inputs.others), strict=True))
    write_study_sheet(
        snakemake.output[0],
        house=house,
        photos={name: path for name, path in files.items() if path.is_file()},
        rooms_of_photo=rooms_of_photos(inputs.assignment or None, house),
        textures={
            method: made.get(method) or Path(inputs.compared) / "0.0" / method
            for method in params.methods
        },
    )
