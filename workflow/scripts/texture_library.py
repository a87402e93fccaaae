"""Rule texture_library: procedural materials or a user's folder -> tiles to retrieve from."""

from plan2scene.textures.library import write_library
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    write_library(
        snakemake.output[0],
        folder=snakemake.params.folder,
        per_substance=snakemake.params.per_substance,
        seed=snakemake.params.seed,
        size_px=snakemake.params.size_px,
    )
