"""Rule doubts: plan, photos and their places -> a page of doubtful results."""

from plan2scene.plans.scene_json import read_scene_json
from plan2scene_app.doubts.page import DoubtFiles, write_doubts
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    inputs = snakemake.input
    write_doubts(
        snakemake.output[0],
        snakemake.params.photo_folder,
        DoubtFiles(
            inputs.table,
            inputs.get("masks"),
            inputs.get("cameras"),
            inputs.get("overlay"),
            inputs.get("doubts"),
        ),
        house=read_scene_json(inputs.scene, snakemake.wildcards.house),
    )
