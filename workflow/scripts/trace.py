"""Rule trace: a picture of a plan -> plan JSON, overlay, doubts."""

from plan2scene_app.tracing.trace import write_trace
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    write_trace(
        snakemake.input.picture,
        snakemake.output.plan,
        metres_per_pixel=snakemake.params.metres_per_pixel,
        model=snakemake.params.model,
        fixture_model=snakemake.params.fixture_model,
    )
