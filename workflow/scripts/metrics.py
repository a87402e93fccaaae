"""Rule metrics: tiles by every method of the table, and crops -> metrics and features."""

from pathlib import Path

from plan2scene.evaluation.measure import Networks, measure_textures, reference_features
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    inputs, params = snakemake.input, snakemake.params
    names = {"dataset": params.dataset, "house": snakemake.wildcards.house}
    networks = Networks(**{name: Path(path) for name, path in params.models.items()})
    measure_textures(
        inputs.textures,
        inputs.crops,
        params.hidden,
        params.methods,
        snakemake.output.metrics,
        networks=networks,
        **names,
    )
    reference_features(inputs.crops, networks.features, snakemake.output.references, **names)
