"""Rule convert_propagation: a released checkpoint and means of training surfaces -> weights."""

import torch

from plan2scene.checkpoints.convert import convert_checkpoint
from plan2scene.checkpoints.means import training_means, training_surfaces
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.workflow.jobs import job

with job(snakemake.log[0]):
    torch.set_num_threads(snakemake.threads)
    found, params = snakemake.input, snakemake.params
    models = found.texture_model, found.naive_model
    means = training_means(
        (
            read_scene_json(scene, house),
            training_surfaces(crops, *models, house=house, seed=params.seed),
        )
        for house, scene, crops in zip(params.houses, found.scenes, found.crops, strict=True)
    )
    convert_checkpoint("propagation", found.checkpoint, snakemake.output[0], means=means)
