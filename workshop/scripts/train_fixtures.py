"""Rule train_fixtures: drawings of synthetic rooms -> the fixture network and its card."""

from plan2scene_workshop.plans.fixture_training import FixtureSettings, train_fixtures
from plan2scene_workshop.training.job import training_job

with training_job(snakemake) as run:
    train_fixtures(
        snakemake.output.model,
        snakemake.output.card,
        settings=FixtureSettings(**snakemake.params.settings),
        **run,
    )
