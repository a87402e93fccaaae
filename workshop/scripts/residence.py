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
        options=ResidenceOptions(
            photo_count=tuple(params.photos),
            hidden_room_share=params.hidden_room_share,
            height=params.height,
            width=params.width,
            samples_per_pixel=params.samples_per_pixel,
            jpeg_quality=tuple(params.jpeg_quality),
            tile_px=params.tile_px,
            random_room_share=params.random_room_share,
            variant=params.variant,
        ),
        # Textures of the training houses are not seen in the others.
        textures=load_texture_folder(folder, "train" if split == "train" else "val")
        if folder
        else (),
    )
