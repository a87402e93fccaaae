"""Rule textures: propagated embeddings, crops and models -> a tile, and a map, per surface."""

from pathlib import Path

from plan2scene.textures.house_textures import make_textures
from plan2scene.textures.inputs import HouseData, HouseFiles, TextureSettings, Visible
from plan2scene.workflow.jobs import job

with job(snakemake.log[0]):
    found, params = snakemake.input, snakemake.params
    asked = params.textures
    files = HouseFiles.of(found, snakemake.wildcards.house)
    inputs = HouseData(files).at(
        Visible(Path(found.propagated), asked["hidden"]),
        {name: Path(path) for name, path in asked["models"].items()},
        TextureSettings(params.seed, params.size_px, asked["seam_correction"], snakemake.threads),
    )
    make_textures(
        snakemake.wildcards.method,
        inputs,
        snakemake.output[0],
        maps=asked["maps"],
        walls=asked["walls"],
    )
