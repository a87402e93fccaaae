"""Rule places: masks and plan of a house -> where each photo was taken, and the rooms it shows."""

from plan2scene.datasets.assignments import rooms_of_photos
from plan2scene.photos.locate.locate_photos import locate_photos, write_photo_rooms
from plan2scene.plans.scene_json import read_scene_json
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    masks, cameras = snakemake.input.get("masks"), snakemake.output.get("cameras")
    house = read_scene_json(snakemake.input.scene, snakemake.wildcards.house)
    assigned = rooms_of_photos(
        snakemake.input.assignment or None, house, traced=snakemake.params.traced
    )
    if masks:
        locate_photos(
            house,
            assigned,
            masks,
            cameras,
            name_hints=snakemake.params.name_hints,
            threads=snakemake.threads,
        )
    write_photo_rooms(house, assigned, cameras, snakemake.output.rooms, snakemake.output.table)
