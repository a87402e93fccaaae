"""Rule locate: plan, masks and cameras of a house -> cameras.json with the photos' places."""

from plan2scene.datasets import rooms_of_photos
from plan2scene.floorplans.scene_json import read_scene_json
from plan2scene.jobs import job
from plan2scene.photos.locate.stage import locate_photos

with job(snakemake.log[0]):
    house = read_scene_json(snakemake.input.scene, snakemake.wildcards.house)
    locate_photos(
        house,
        rooms_of_photos(snakemake.input.assignment or None, house),
        snakemake.input.masks,
        snakemake.output[0],
    )
