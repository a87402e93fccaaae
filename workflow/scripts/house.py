"""Rule house: plan, textures, crops -> GLB, scene.json with textures, pictures, offline viewer."""

from plan2scene.mesh.build import build_house
from plan2scene.plans import read_scene_json
from plan2scene.workflow.jobs import job
from plan2scene_app.viewer.viewer_page import build_viewer, read_facts

with job(snakemake.log[0]):
    house_id, given, made = snakemake.wildcards.house, snakemake.input, snakemake.output
    build_house(
        given.scene,
        given.textures,
        made.glb,
        made.scene,
        made.preview,
        made.rooms,
        house_id=house_id,
        objects=snakemake.params.objects,
        relief=snakemake.params.relief,
        traced=snakemake.params.traced,
        threads=snakemake.threads,
    )
    house = read_scene_json(given.scene, house_id)
    facts = read_facts(given.propagated, given.crops, given.get("cameras"), house)
    build_viewer(made.glb, made.viewer, house_id=house_id, facts=facts)
