"""Rule patterns: photos, their planes and shared materials -> patterns of the floors."""

from pathlib import Path

from plan2scene.io import read_parquet
from plan2scene.photos.patterns.house_patterns import write_patterns
from plan2scene.photos.patterns.views import PhotoFiles
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.propagation.substances import jointed_floors
from plan2scene.stage_json import read_stage_json
from plan2scene_app.workflow.jobs import job

with job(snakemake.log[0]):
    inputs, params = snakemake.input, snakemake.params
    photos = {
        name: Path(params.photo_folder) / name
        for name in read_stage_json(inputs.cameras, "cameras")
    }
    files = PhotoFiles(photos, Path(inputs.masks), Path(inputs.cameras), Path(inputs.planes))
    house = read_scene_json(inputs.scene, snakemake.wildcards.house)
    write_patterns(
        files,
        house,
        inputs.crops,
        inputs.materials,
        snakemake.output[0],
        dataset=params.dataset,
        looks=jointed_floors(read_parquet(inputs.embeddings)[0], house),
        threads=snakemake.threads,
    )
