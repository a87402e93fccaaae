"""Measure the texture models on one clean crop of each texture of a folder.

    python benchmarks/clean_crops.py --textures FOLDER [--split val] [--seeds 3]

FOLDER is described in ``benchmarks/exemplar.py``. Each crop is embedded and decoded. The script
prints means and standard deviations over seeds (which change windows and noise) of COLOR, FREQ,
TILE, the median wrap ratio and the accuracy of the substance, for ``synth``, ``synth-large`` and
``naivesynth`` with the shipped weights.
"""

import argparse

import numpy as np
import torch

from plan2scene.metrics.color_freq_tile import color_distance, freq_distance, tile_score
from plan2scene.seeds import derive_seed, generator
from plan2scene.textures.decoding import match_statistics
from plan2scene.textures.model.embedding import embed_crops
from plan2scene.textures.model.texture_model import decode_textures, load_texture_model
from plan2scene.textures.seams import wrap_ratio
from plan2scene.weights import MODELS
from plan2scene_workshop.texture.data import TextureSet, random_crop, scanned_textures


def figures(tiles: np.ndarray, crops: np.ndarray, right: float) -> list[float]:
    pairs = list(zip(tiles, crops, strict=True))
    return [
        float(np.mean([color_distance(tile, crop) for tile, crop in pairs])),
        float(np.mean([freq_distance(tile, crop) for tile, crop in pairs])),
        float(np.mean([tile_score(tile) for tile in tiles])),
        float(np.median([wrap_ratio(tile) for tile in tiles])),
        right,
    ]


def one_seed(textures: TextureSet, seed: int) -> dict[str, list[float]]:
    rng = generator(seed, "clean crops")
    crops = np.stack([random_crop(tile, rng, closest_px=192) for tile in textures.tiles])
    seeds = [derive_seed(seed, "clean crops", index) for index in range(len(crops))]
    rows = {}
    for name, file in (("synth", "texture"), ("naivesynth", "naivesynth")):
        model = load_texture_model(MODELS / f"{file}.safetensors")
        found = embed_crops(model, crops, textureness=False)
        named = found.substance_probabilities
        right = (named.argmax(1) == textures.substances).mean() if named.shape[1] else np.nan
        tiles = decode_textures(model, found.codes, seeds)
        rows[name] = figures(tiles, crops, float(right))
        if name == "synth":
            triples = zip(tiles, crops, seeds, strict=True)
            large = np.stack([match_statistics(*triple) for triple in triples])
            rows["synth-large"] = figures(large, crops, float(right))
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--textures", required=True)
    parser.add_argument("--split", default="val")
    parser.add_argument("--seeds", type=int, default=3)
    options = parser.parse_args()
    torch.set_num_threads(1)
    textures = scanned_textures(options.textures, options.split)
    runs = [one_seed(textures, seed) for seed in range(options.seeds)]
    print(f"{len(textures)} textures, split {options.split}, {options.seeds} seeds")
    print("| method | COLOR | FREQ | TILE | wrap | substance |\n|" + "---|" * 6)
    for name in runs[0]:
        values = np.array([run[name] for run in runs])
        pairs = zip(values.mean(0), values.std(0), strict=True)
        cells = ["-" if np.isnan(m) else f"{m:.3f} +- {s:.3f}" for m, s in pairs]
        print(f"| {name} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
