"""Rule train_plans: drawings of synthetic homes -> weights of the plan network and their card."""

from plan2scene_workshop.plans.run import train_plans
from plan2scene_workshop.plans.settings import PlanSettings
from plan2scene_workshop.training.job import training_job

with training_job(snakemake) as run:
    train_plans(
        snakemake.output.model,
        snakemake.output.card,
        settings=PlanSettings(**snakemake.params.settings),
        **run,
    )
