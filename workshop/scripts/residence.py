"""Rule residence: a seed -> one synthetic house with photos and truth."""

from pathlib import Path

from plan2scene_app.workflow.jobs import job
from plan2scene_workshop.homes.residences import ResidenceOptions, write_residence
from plan2scene_workshop.homes.snapshots import SnapshotOptions, write_snapshots
from plan2scene_workshop.rendering.sources import load_sources

with job(snakemake.log[0]):
    params, split = snakemake.params, snakemake.wildcards.split
    root, house = Path(snakemake.output.plan).parents[2], snakemake.wildcards.house
    folders = [params.textures] if isinstance(params.textures, str) else params.textures or []
    # Houses of the train split and of the other splits use different data.
    sources = load_sources(
        tuple(folders), params.environments, params.models, train=split == "train"
    )
    if params.snapshots is None:
        options = ResidenceOptions(**params.options)
        write_residence(root, house, split, params.seed, options=options, sources=sources)
    else:
        shared = {key: params.options[key] for key in ("jpeg_quality", "variant")}
        options = SnapshotOptions(**params.snapshots, **shared)
        write_snapshots(root, house, split, params.seed, options, sources=sources)
