"""The training run of a texture model: textures in, weights and a model card out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np

from plan2scene.errors import InputError
from plan2scene.metrics.color_freq_tile import color_distance, freq_distance, tile_score
from plan2scene.provenance import file_hash
from plan2scene.seeds import derive_seed, generator
from plan2scene.textures.model.embedding import embed_crops
from plan2scene.textures.model.texture_model import (
    Architecture,
    TextureModel,
    decode_textures,
    low_precision_is_fast,
)
from plan2scene.textures.seams import wrap_ratio
from plan2scene.weights import save_model_file
from plan2scene_workshop.texture.data import TextureSet, random_crop, read_materials, seen_textures
from plan2scene_workshop.texture.settings import TextureSettings
from plan2scene_workshop.texture.training import train_texture_model
from plan2scene_workshop.training.card import Card, table, write_card
from plan2scene_workshop.training.loop import best_device

#: Architecture of each embedded model: the paper's, except for an encoder that a CPU can train.
ARCHITECTURES: Mapping[str, Architecture] = {
    "texture": Architecture(width=192, encoder="statistics"),
    "naivesynth": Architecture(width=192, encoder="statistics", delta_hsv=False, substances=0),
}
_WHAT = {
    "texture": "The paper's texture model (section 5.2): delta-HSV, 8 + 3 numbers, substance.",
    "naivesynth": "The unmodified model of Henzler et al. (2020): 8 numbers, no substance.",
}
_FIGURES = """
One clean crop of each held-out texture, embedded and decoded at 128 px (means; wrap: median;
textureness: relative Gram error of the embedded filter bank):

"""


def train_texture(
    name: str,
    materials: str | Path,
    output: str | Path,
    card: str | Path,
    *,
    settings: TextureSettings,
    seed: int,
    checkpoint: Path | None = None,
) -> None:
    """Train the model `name` (``texture`` or ``naivesynth``); write weights and card.

    `materials` is a file of :func:`write_materials`. Training continues from `checkpoint` if it is
    of this run.
    """
    if name not in ARCHITECTURES:
        raise InputError(f"a model of {tuple(ARCHITECTURES)}", repr(name))
    device = best_device()
    if device == "cpu" and not low_precision_is_fast():
        settings = replace(settings, low_precision=False)
    shape = ARCHITECTURES[name]
    textures, held_out = read_materials(materials)
    trained = train_texture_model(
        shape,
        textures,
        settings,
        seed,
        device=device,
        checkpoint=checkpoint,
        run=file_hash(materials),
    )
    model = trained.network.cpu()
    model.decoder.low_precision = False
    save_model_file(output, model.state_dict(), asdict(model.architecture))
    figures = {kind: measure(model, group, seed) for kind, group in held_out.items()}
    head = ["held-out textures", "n", *next(iter(figures.values()))]
    rows = {kind: [len(held_out[kind]), *found.values()] for kind, found in figures.items()}
    architecture = ", ".join(f"{key} {value}" for key, value in asdict(shape).items())
    what = f"{_WHAT[name]} The decoder's noise is periodic, so its tiles have no seam."
    write_card(
        card,
        Card(
            name,
            f"{what}\n\nArchitecture: {architecture}.",
            seen_textures(textures),
            settings,
            seed,
            _FIGURES + table(head, rows),
        ),
        trained,
        output,
    )


def measure(model: TextureModel, textures: TextureSet, seed: int) -> dict[str, float]:
    """Embed and decode one clean crop of each texture at 128 px; return mean figures.

    ``color``, ``freq``, ``tile`` (plan2scene.metrics), ``wrap`` (median of the tiles' wrap ratios),
    ``substance`` (accuracy; NaN without a substance head), ``textureness``.
    """
    rng = generator(seed, "texture held out")
    crops = np.stack([random_crop(tile, rng, closest_px=192) for tile in textures.tiles])
    found = embed_crops(model, crops, seed=derive_seed(seed, "textureness"))
    seeds = [derive_seed(seed, "texture held out", index) for index in range(len(crops))]
    tiles = decode_textures(model, found.codes, seeds)
    named = found.substance_probabilities
    right = named.argmax(1) == textures.substances if named.shape[1] else np.array([np.nan])
    pairs = list(zip(tiles, crops, strict=True))
    return {
        "color": float(np.mean([color_distance(tile, crop) for tile, crop in pairs])),
        "freq": float(np.mean([freq_distance(tile, crop) for tile, crop in pairs])),
        "tile": float(np.mean([tile_score(tile) for tile in tiles])),
        "wrap": float(np.median([wrap_ratio(tile) for tile in tiles])),
        "substance": float(np.mean(right)),
        "textureness": float(found.textureness.mean()),
    }
