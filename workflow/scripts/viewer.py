"""Rule viewer: GLB, crops, photos and their places -> the house in one offline page."""

from pathlib import Path

from plan2scene.plans.scene_json import read_scene_json
from plan2scene_app.viewer.viewer_page import build_viewer, read_facts
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    house_id, inputs = snakemake.wildcards.house, snakemake.input
    house = read_scene_json(inputs.scene, house_id)
    photos = Path(snakemake.params.photo_folder)
    facts = read_facts(inputs.propagated, inputs.crops, inputs.get("cameras"), house, photos)
    build_viewer(inputs.glb, snakemake.output[0], house_id=house_id, title=house.title, facts=facts)
