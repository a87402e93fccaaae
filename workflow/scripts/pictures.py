"""Rule pictures: plan, textures, places of photos -> house, rooms, views beside photos."""

import json
from pathlib import Path

from plan2scene_app.pictures.house_pictures import draw_house
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    inputs, output, params = snakemake.input, snakemake.output, snakemake.params
    draw_house(
        inputs.scene,
        inputs.textures,
        output.preview,
        output.rooms,
        output.views,
        output.patterns,
        house_id=snakemake.wildcards.house,
        photos={name: Path(params.photo_folder) / name for name in json.loads(params.names)},
        cameras=inputs.get("cameras"),
        patterns=inputs.get("patterns"),
        objects=params.objects,
        traced=params.traced,
        threads=snakemake.threads,
    )
