"""Rule convert_propagation: a released checkpoint and means of training surfaces -> weights."""

from plan2scene.checkpoints.convert import convert_checkpoint
from plan2scene.checkpoints.means import training_means
from plan2scene.jobs import job

with job(snakemake.log[0]):
    found = snakemake.input
    files = zip(found.scenes, found.surfaces, strict=True)
    convert_checkpoint(
        "propagation",
        found.checkpoint,
        snakemake.output[0],
        means=training_means(dict(zip(snakemake.params.houses, files, strict=True))),
    )
