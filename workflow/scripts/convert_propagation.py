"""Rule convert_propagation: a released checkpoint and training crops -> our weight file."""

import torch

from plan2scene.checkpoints.convert import convert_checkpoint
from plan2scene.checkpoints.means import training_means, training_surfaces
from plan2scene.plans.scene_json import read_scene_json
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    torch.set_num_threads(snakemake.threads)
    inputs, params = snakemake.input, snakemake.params
    models = inputs.texture_model, inputs.naive_model
    means = training_means(
        (
            read_scene_json(scene, house),
            training_surfaces(crops, *models, house=house, seed=params.seed),
        )
        for house, scene, crops in zip(params.houses, inputs.scenes, inputs.crops, strict=True)
    )
    convert_checkpoint("propagation", inputs.checkpoint, snakemake.output[0], means=means)
