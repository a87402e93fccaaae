"""Rule crop_pool: crops of the pool's houses -> one crop for each of their surfaces."""

from plan2scene.textures.crops import write_pool
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    write_pool(
        snakemake.input.scenes,
        snakemake.input.crops,
        snakemake.params.houses,
        snakemake.output[0],
        dataset=snakemake.params.dataset,
    )
