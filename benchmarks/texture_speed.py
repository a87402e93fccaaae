"""How long the steps of the texture model take, beside what was asked.

    python benchmarks/texture_speed.py [--threads 2] [--rounds 5]

Prints a Markdown table of wall times (median and least of the rounds): embedding and textureness
of a crop in a batch of 64, decoding a 128 px tile in a batch of 16, an exemplar of six crops at
128 px, a tile brought to a crop's statistics, and a training step of 16 crops.
"""

import argparse
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import torch

from plan2scene.materials import random_material
from plan2scene.textures.constrained import match_statistics
from plan2scene.textures.exemplar.choice import ExemplarCrop
from plan2scene.textures.exemplar.make import make_exemplar
from plan2scene.textures.model.decoder import low_precision_is_fast
from plan2scene.textures.model.embedding import embed_crops
from plan2scene.textures.model.network import load_texture_model
from plan2scene.textures.model.synthesis import decode_textures
from plan2scene.workflow.jobs import keep_freed_memory
from plan2scene_workshop.texture.data import TextureSet, procedural_textures
from plan2scene_workshop.texture.degradation import degrade
from plan2scene_workshop.texture.settings import TextureSettings
from plan2scene_workshop.texture.training import texture_trainer

MODEL = Path(__file__).parents[1] / "resources" / "models" / "texture.safetensors"
BATCH = 64


def steps(crops: np.ndarray, textures: TextureSet) -> dict[str, tuple[Callable, int, float]]:
    """Return name: (what to time, things it does, milliseconds asked for each)."""
    model = load_texture_model(MODEL)
    codes = embed_crops(model, crops[:16], textureness=False).codes
    tiles = decode_textures(model, codes, list(range(16)))
    tile = random_material("wood", 3, size_px=128).albedo
    shown = [ExemplarCrop(c.image, c.side, 1.0) for c in degrade(tile, 0)]
    options = TextureSettings(
        batch=16, tile_share=0.0, scanned_share=0.0, low_precision=low_precision_is_fast()
    )
    trainer = texture_trainer(model.architecture, textures, options, 0)
    return {
        "embedding and textureness": (lambda: embed_crops(model, crops), len(crops), 20.0),
        "decoding": (lambda: decode_textures(model, codes, list(range(16))), 16, 15.0),
        "exemplar": (lambda: make_exemplar(shown, size_px=128), 1, 1500.0),
        "a crop's statistics": (lambda: match_statistics(tiles[0], crops[0], 0), 1, float("nan")),
        "training step of 16": (trainer.train_step, 1, 1500.0),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    torch.set_num_threads(options.threads)
    keep_freed_memory()  # as every job of the workflow
    textures = procedural_textures(BATCH, 7)
    crops = np.ascontiguousarray(textures.tiles[:, ::2, ::2])
    print(f"{options.threads} threads, {options.rounds} rounds, bfloat16 {low_precision_is_fast()}")
    print("| step | median ms | least ms | asked |\n|---|---|---|---|")
    for name, (run, count, asked) in steps(crops, textures).items():
        run()
        times = []
        for _ in range(options.rounds):
            start = time.perf_counter()
            run()
            times.append((time.perf_counter() - start) * 1000 / count)
        limit = "-" if np.isnan(asked) else f"{asked:.0f}"
        print(f"| {name} | {np.median(times):.1f} | {min(times):.1f} | {limit} |", flush=True)


if __name__ == "__main__":
    main()
