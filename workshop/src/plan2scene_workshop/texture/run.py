"""The training run of a texture model: textures in, weights and a model card out."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
import torch

from plan2scene.errors import InputError
from plan2scene.io import atomic_path
from plan2scene.metrics.color import color_distance
from plan2scene.metrics.freq import freq_distance
from plan2scene.metrics.tile import tile_score
from plan2scene.seeds import derive_seed, generator
from plan2scene.textures.model.decoder import low_precision_is_fast
from plan2scene.textures.model.embedding import embed_crops
from plan2scene.textures.model.network import Architecture, TextureModel, architecture_header
from plan2scene.textures.model.synthesis import decode_textures
from plan2scene.weights import save_model_file
from plan2scene_workshop.texture.data import (
    TextureSet,
    join_sets,
    procedural_textures,
    random_crop,
    scanned_textures,
)
from plan2scene_workshop.texture.settings import TextureTraining
from plan2scene_workshop.texture.training import train_texture_model

#: Architecture of each embedded model: the paper's but for an encoder that a CPU can train.
ARCHITECTURES: Mapping[str, Architecture] = {
    "texture": Architecture(width=192, encoder="statistics"),
    "naivesynth": Architecture(width=192, encoder="statistics", delta_hsv=False, substances=0),
}


@dataclass(frozen=True)
class TextureData:
    """Where a run's textures come from.

    Attributes
    ----------
    procedural, held_out : int
        Procedural materials to train on, and others to measure with.
    seed : int
        Of the materials, the initial weights and every step.
    folder : path, optional
        Real textures beside them: a folder with an ``index.csv`` of splits train and val.
    cache : path, optional
        Keeps the procedural materials between runs.
    """

    procedural: int = 1200
    held_out: int = 64
    seed: int = 0
    folder: str | Path | None = None
    cache: Path | None = None


def train_texture(
    name: str,
    data: TextureData,
    options: TextureTraining,
    output: str | Path,
    card: str | Path,
    *,
    checkpoint: Path | None = None,
    device: str = "cpu",
) -> None:
    """Train the model `name` (``texture`` or ``naivesynth``); write weights and card."""
    if name not in ARCHITECTURES:
        raise InputError(f"a model of {tuple(ARCHITECTURES)}", repr(name))
    if device == "cpu" and not low_precision_is_fast():
        options = replace(options, low_precision=False)
    textures = procedural_textures(data.procedural, data.seed, data.cache)
    held_out = {"procedural": procedural_textures(data.held_out, data.seed + 1_000_003)}
    if data.folder is not None:
        textures = join_sets(textures, scanned_textures(data.folder, "train"))
        held_out["scanned"] = scanned_textures(data.folder, "val")
    model, seconds = train_texture_model(
        ARCHITECTURES[name], textures, options, data.seed, checkpoint=checkpoint, device=device
    )
    model = model.to("cpu")
    model.decoder.low_precision = False
    save_model_file(output, model.state_dict(), architecture_header(model))
    figures = {kind: measure(model, group, data.seed) for kind, group in held_out.items()}
    with atomic_path(card) as temporary:
        text = _card(name, data, options, len(textures), seconds / 60.0, figures)
        temporary.write_text(text, encoding="utf-8")
    if checkpoint is not None:
        checkpoint.unlink(missing_ok=True)


def measure(model: TextureModel, textures: TextureSet, seed: int) -> dict[str, float]:
    """Return mean figures of decoding one clean crop of each texture at 128 px.

    ``color``, ``freq``, ``tile`` (plan2scene.metrics), ``wrap`` (median over textures of the mean
    difference across the wrap edge over that inside), ``substance`` (share named rightly; NaN
    without a head), ``textureness``.
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


def wrap_ratio(tile: np.ndarray) -> float:
    """Return the mean step across the wrap edges of a tile (h, w, 3) over the mean step inside."""
    image = tile.astype(np.float64)
    across = np.abs(image[0] - image[-1]).mean() + np.abs(image[:, 0] - image[:, -1]).mean()
    inside = np.abs(np.diff(image, axis=0)).mean() + np.abs(np.diff(image, axis=1)).mean()
    return float(across / max(inside, 1e-6))


def _card(
    name: str,
    data: TextureData,
    options: TextureTraining,
    count: int,
    minutes: float,
    figures: Mapping[str, Mapping[str, float]],
) -> str:
    """Return the model card as Markdown."""
    columns = ("color", "freq", "tile", "wrap", "substance", "textureness")
    head = "| held-out textures | " + " | ".join(columns) + " |\n|" + "---|" * 7
    rows = "\n".join(
        f"| {kind} | " + " | ".join(f"{values[c]:.3f}" for c in columns) + " |"
        for kind, values in figures.items()
    )
    what = {
        "texture": "The paper's texture model (section 4.3): delta-HSV, 8 + 3 numbers, substance.",
        "naivesynth": "The unmodified model of Henzler et al. (2020): 8 numbers, no substance.",
    }[name]
    folder = (
        "no other textures" if data.folder is None else "real textures (train split) of a folder"
    )
    settings = ", ".join(f"{key} {value}" for key, value in asdict(options).items())
    threads, cores = torch.get_num_threads(), os.cpu_count()
    shape = ", ".join(f"{key} {value}" for key, value in asdict(ARCHITECTURES[name]).items())
    return f"""# {name}

{what}
The decoder's noise is periodic, so its tiles have no seam.

- Architecture: {shape}.
- Data: {count} textures: {data.procedural} procedural materials (seed {data.seed}) and {folder}.
- Loss: Gram error of the {options.statistics} statistics, log spectrum, colour distribution, COLOR
  and FREQ with gradients, cross-entropy of the substance where there is a head.
- Training: {settings}.
- {minutes:.0f} minutes with {threads} thread(s) on a machine of {cores} cores.
- Command: `snakemake -j1 train_{name} --configfile config/training.yaml`

One clean crop of each held-out texture, embedded and decoded at 128 px (means; wrap: median;
textureness: relative Gram error of the embedded filter bank):

{head}
{rows}
"""
