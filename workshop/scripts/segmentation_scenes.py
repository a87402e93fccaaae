"""Rule segmentation_scenes: drawn rooms with labels, for the segmentation network."""

from plan2scene.jobs import job
from plan2scene_workshop.segmentation.run import draw_scenes
from plan2scene_workshop.segmentation.settings import SegmentationSettings

with job(snakemake.log[0]):
    draw_scenes(
        snakemake.output[0],
        settings=SegmentationSettings(**snakemake.params.settings),
        seed=snakemake.params.seed,
    )
