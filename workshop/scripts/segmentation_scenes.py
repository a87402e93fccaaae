"""Rule segmentation_scenes: drawn rooms with labels, for the segmentation network."""

from plan2scene.jobs import job
from plan2scene_workshop.segmentation.training import draw_scenes

with job(snakemake.log[0]):
    draw_scenes(
        snakemake.output[0],
        settings=snakemake.params.settings,
        seed=snakemake.params.seed,
    )
