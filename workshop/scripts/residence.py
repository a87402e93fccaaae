"""Rule residence: a seed -> one synthetic house with photos and truth."""

from pathlib import Path

from plan2scene.jobs import job
from plan2scene.materials import load_texture_folder
from plan2scene_workshop.homes.residences import ResidenceOptions, write_residence

with job(snakemake.log[0]):
    params = snakemake.params
    folder, split = params.textures, snakemake.wildcards.split
    write_residence(
        Path(snakemake.output.plan).parents[2],
        snakemake.wildcards.house,
        split,
        params.seed,
        options=ResidenceOptions(**params.options),
        # Textures of the training houses are not seen in the others.
        textures=load_texture_folder(folder, "train" if split == "train" else "val")
        if folder
        else (),
    )
