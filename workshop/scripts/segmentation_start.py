"""Rule segmentation_start: drawn rooms -> weights that training on photos starts from."""

from plan2scene.jobs import job
from plan2scene_workshop.segmentation.training import train_start

with job(snakemake.log[0]):
    train_start(
        snakemake.input[0],
        snakemake.output[0],
        settings=snakemake.params.settings,
        seed=snakemake.params.seed,
        threads=snakemake.threads,
    )
