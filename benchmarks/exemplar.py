"""Compare texture methods with clean tiles, from photo-like crops or regular patterns.

``python benchmarks/exemplar.py patterns [--cases 20]``
``python benchmarks/exemplar.py methods  [--textures FOLDER] [--seeds 3]``

FOLDER has a subfolder of tileable images for each substance and an ``index.csv`` with columns id,
split; without FOLDER the textures are 60 procedural materials. Tables are Markdown; seconds are
processor time. The crops are those of ``plan2scene_workshop.texture.degradation``; wrap ratios are
``plan2scene.textures.seams.wrap_ratio``.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import cv2
import numpy as np
from exemplar_patterns import pattern_rows

from plan2scene.colour import delta_e_2000, median_colour, rgb_to_lab
from plan2scene.house import SUBSTANCES
from plan2scene.materials import random_material
from plan2scene.materials.material import Material
from plan2scene.metrics.color_freq_tile import color_distance, freq_distance, tile_score
from plan2scene.seeds import derive_seed
from plan2scene.textures.exemplar.make import ExemplarCrop, make_exemplar
from plan2scene.textures.library import generated_library
from plan2scene.textures.seams import make_seamless, wrap_ratio
from plan2scene_app.single_tile import CROP_PX, LIBRARY_TILES
from plan2scene_workshop.rendering.index import textures_of_split
from plan2scene_workshop.texture.degradation import DegradedCrop, degrade

ROLLS = 8
PROCEDURAL = 15  # number of materials of each substance if no folder is given
SHOWN = ("clean", "crop", "synth", "synth-large", "exemplar")
FIGURES = ("COLOR", "FREQ", "TILE", "dE2000", "wrap 50 %", "wrap 90 %", "rolled 90 %", "light", "s")


def load_textures(args: argparse.Namespace) -> list[Material]:
    """Return the folder's textures of a split, or procedural ones that no model was trained on."""
    if args.textures:
        return textures_of_split(args.textures, args.split, size_px=CROP_PX)[:: args.every]
    return [
        random_material(name, derive_seed(0, "exemplar benchmark", name, k), size_px=CROP_PX)
        for name in SUBSTANCES
        for k in range(0, PROCEDURAL, args.every)
    ]


def light_residue(tile: np.ndarray) -> float:
    """Return the standard deviation of a tile's grey values after a periodic blur of sigma 12."""
    grey = cv2.cvtColor(tile, cv2.COLOR_RGB2GRAY).astype(np.float64)
    margin = 48
    wide = cv2.copyMakeBorder(grey, margin, margin, margin, margin, cv2.BORDER_WRAP)
    return float(cv2.GaussianBlur(wide, (0, 0), 12.0)[margin:-margin, margin:-margin].std())


def flattened(crop: np.ndarray) -> np.ndarray:
    """Return a crop divided by its sigma-12 blur with its median colour kept: a simple baseline."""
    values = crop.astype(np.float64) + 1.0
    even = values / cv2.GaussianBlur(values, (0, 0), 12.0)
    even *= np.median(values, axis=(0, 1)) / np.median(even, axis=(0, 1))
    return np.clip(np.rint(even - 1.0), 0, 255).astype(np.uint8)


def rolled_ratios(tile: np.ndarray, seed: int) -> list[float]:
    """Return the wrap ratios of a tile at eight random rolls."""
    rng = np.random.default_rng(seed)
    return [wrap_ratio(np.roll(tile, rng.integers(0, len(tile), 2), (0, 1))) for _ in range(ROLLS)]


def figures(tile: np.ndarray, clean: np.ndarray, seconds: float, seed: int) -> list[float]:
    """Return a method's figures on one texture: errors, seams, light (1 if it is even), seconds."""
    away = delta_e_2000(rgb_to_lab(median_colour(tile)), rgb_to_lab(median_colour(clean)))
    dark = light_residue(tile) <= 1.25 * light_residue(clean) + 0.3
    return [
        color_distance(tile, clean),
        freq_distance(tile, clean),
        tile_score(tile),
        float(away),
        wrap_ratio(tile),
        float(dark),
        seconds,
        *rolled_ratios(tile, seed),
    ]


def summary(rows: np.ndarray) -> list[float]:
    """Return :data:`FIGURES` over the rows (n, 7 + rolls) of n textures."""
    mean = rows.mean(axis=0)
    wraps, rolled = rows[:, 4], rows[:, 7:]
    return [
        *mean[:4],
        float(np.percentile(wraps, 50)),
        float(np.percentile(wraps, 90)),
        float(np.percentile(rolled, 90)),
        mean[5],
        mean[6],
    ]


def print_table(
    name: str, columns: Sequence[str], rows: Sequence[tuple[str, Sequence[str]]]
) -> None:
    print(f"\n| {name} | " + " | ".join(columns) + " |")
    print("|---" * (1 + len(columns)) + "|")
    for label, cells in rows:
        print(f"| {label} | " + " | ".join(cells) + " |")


def exemplar_method(crops: Sequence[DegradedCrop], known: bool) -> np.ndarray:
    """Return the exemplar; if `known`, the crops have their scales (a tile is 1 m)."""
    scale = [crop.side if known else float("nan") for crop in crops]
    sharp = [crop.side if known else 0.75 for crop in crops]
    made = make_exemplar(
        [ExemplarCrop(c.image, m, s) for c, m, s in zip(crops, scale, sharp, strict=True)],
        size_px=CROP_PX,
    )
    # An overexposed surface has no exemplar. The stage then decodes a tile; here, the crop counts.
    return crops[0].image if made is None else made.image


def decoders() -> dict[str, Callable[[Sequence[DegradedCrop]], np.ndarray]]:
    """Return the methods that decode tiles with the shipped models."""
    from plan2scene.colour import clipped_share
    from plan2scene.textures.decoding import even_crop, match_statistics
    from plan2scene.textures.model.embedding import embed_crops
    from plan2scene.textures.model.texture_model import decode_textures, load_texture_model
    from plan2scene.textures.observed_surfaces import surface_embedding
    from plan2scene.weights import MODELS

    model = load_texture_model(MODELS / "texture.safetensors")
    naive = load_texture_model(MODELS / "naivesynth.safetensors")
    seeds = [derive_seed(0, "tile")]

    def naivesynth(crops: Sequence[DegradedCrop]) -> np.ndarray:
        found = embed_crops(naive, np.stack([crop.image for crop in crops]), textureness=False)
        return decode_textures(naive, found.codes.mean(axis=0)[None], seeds, CROP_PX)[0]

    def synth(crops: Sequence[DegradedCrop], *, large: bool = False) -> np.ndarray:
        images = np.stack([crop.image for crop in crops])
        found = embed_crops(model, images, seed=0, textureness=True)
        clipped = np.array([clipped_share(image) for image in images])
        best, code = surface_embedding(found.codes, found.textureness, clipped)
        tile = decode_textures(model, code[None], seeds, CROP_PX)[0]
        if not large:
            return tile
        others = list(np.delete(images, best, axis=0))
        return match_statistics(tile, even_crop(images[best], others, code[-3:], CROP_PX), 0)

    return {"naivesynth": naivesynth, "synth": synth, "synth-large": partial(synth, large=True)}


def print_networks(results: dict[str, list[list[np.ndarray]]]) -> None:
    """Print SUBS and FID (embedded network) of the tiles against clean ones, over seeds."""
    from plan2scene.metrics.feature_sets import SurfaceDistances
    from plan2scene.metrics.networks import describe_images
    from plan2scene.metrics.substance_network import load_substance_network
    from plan2scene.weights import MODELS

    network = load_substance_network(MODELS / "features.safetensors")
    clean, right = describe_images(network, results["clean"][0])
    rows = []
    for name, seeds in results.items():
        values = []
        for tiles in seeds:
            features, named = describe_images(network, tiles)
            distances = SurfaceDistances()
            distances.add(list(features[:, None]), list(clean[:, None]))
            values.append([float((named != right).mean()), distances.values()["FID"]])
        rows.append((name, _spread(values)))
    print_table("method", ("SUBS (embedded)", "FID (embedded)"), rows)


def methods(with_synth: bool) -> dict[str, Callable[[Sequence[DegradedCrop]], np.ndarray]]:
    """Return the methods by name; each is a function from crops to a tile."""
    library = generated_library(LIBRARY_TILES, 0, CROP_PX)
    found: dict[str, Callable[[Sequence[DegradedCrop]], np.ndarray]] = {
        "crop": lambda crops: crops[0].image,
        "flattened": lambda crops: flattened(crops[0].image),
        "flattened, seams corrected": lambda crops: make_seamless(flattened(crops[0].image))[0],
        "retrieve": lambda crops: library.tiles[library.nearest(crops[0].image)],
    }
    if with_synth:
        found |= decoders()
    found["exemplar, scale unknown"] = lambda crops: exemplar_method(crops, known=False)
    found["exemplar"] = lambda crops: exemplar_method(crops, known=True)
    return found


def run_methods(args: argparse.Namespace) -> None:
    textures = load_textures(args)
    chosen = methods(not args.no_synth)
    results: dict[str, list[np.ndarray]] = {name: [] for name in ("clean", *chosen)}
    tiles: dict[str, list[list[np.ndarray]]] = {name: [] for name in results}
    for seed in range(args.seeds):
        found: dict[str, list[list[float]]] = {name: [] for name in results}
        for name in tiles:
            tiles[name].append([])
        for k, texture in enumerate(textures):
            clean = texture.albedo
            crops = degrade(clean, derive_seed(seed, texture.name))
            found["clean"].append(figures(clean, clean, 0.0, k))
            tiles["clean"][seed].append(clean)
            for name, method in chosen.items():
                start = time.process_time()
                tile = method(crops)
                seconds = time.process_time() - start
                found[name].append(figures(tile, clean, seconds, k))
                tiles[name][seed].append(tile)
        for name, rows in found.items():
            results[name].append(np.array(rows))
    kind = f"split {args.split}" if args.textures else "procedural"
    print(f"{len(textures)} textures, {kind}, {args.seeds} seeds")
    rows = [(name, _spread([summary(part) for part in parts])) for name, parts in results.items()]
    print_table("method", FIGURES, rows)
    print_networks(tiles)
    _by_substance(results, np.array([texture.substance for texture in textures]))


def _spread(values: Sequence[Sequence[float]]) -> list[str]:
    mean, spread = np.mean(values, axis=0), np.std(values, axis=0)
    if len(values) == 1:
        return [f"{m:.3f}" for m in mean]
    return [f"{m:.3f}±{s:.3f}" for m, s in zip(mean, spread, strict=True)]


def _by_substance(results: dict[str, list[np.ndarray]], substances: np.ndarray) -> None:
    """Print a table of the means per substance."""
    rows = []
    for substance in dict.fromkeys(substances):
        own = substances == substance
        for name in SHOWN:
            if name in results:
                part = np.concatenate([result[own] for result in results[name]])
                rows.append((f"{substance}, {name}", [f"{v:.3f}" for v in summary(part)]))
    print_table("substance, method", FIGURES, rows)


def run_patterns(args: argparse.Namespace) -> None:
    columns = ("cases", "period within 3 %", "autocorrelation of truth's", "at least 0.9")
    rows = [row for turn in (0.0, 20.0, 45.0) for row in pattern_rows(args.cases, turn)]
    print_table("pattern, turned by up to", columns, rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)
    command = commands.add_parser("methods")
    command.set_defaults(run=run_methods)
    command.add_argument("--textures", type=Path)
    command.add_argument("--split", default="val")
    command.add_argument("--every", type=int, default=1, help="take each n-th texture")
    command.add_argument("--seeds", type=int, default=3)
    command.add_argument("--no-synth", action="store_true")
    command = commands.add_parser("patterns")
    command.set_defaults(run=run_patterns)
    command.add_argument("--cases", type=int, default=20)
    args = parser.parse_args()
    cv2.setNumThreads(1)
    args.run(args)


if __name__ == "__main__":
    main()
