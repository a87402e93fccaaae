"""Rule ceilings: a plan that may lack heights, and masks of the photos -> scene.json."""

from plan2scene.datasets.assignments import rooms_of_photos
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.plans.scene_writer import write_scene_json
from plan2scene_app.heights.ceilings import measure_ceilings
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    house = read_scene_json(snakemake.input.drawn, snakemake.wildcards.house)
    assigned = rooms_of_photos(
        snakemake.input.assignment or None, house, traced=snakemake.params.traced
    )
    house = measure_ceilings(
        house,
        assigned,
        snakemake.input.masks,
        name_hints=snakemake.params.name_hints,
        threads=snakemake.threads,
    )
    write_scene_json(house, snakemake.output[0])
