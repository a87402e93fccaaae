"""Ablation study of the texture model: short trainings that differ in one setting each.

    python benchmarks/texture_study.py --textures FOLDER --steps 600 [--only base code_32]

FOLDER holds real tileable textures with an ``index.csv`` of splits (docs/textures.md). The models
are trained on its train split and on procedural materials, and measured on one clean crop of each
texture of its val split. The script prints a Markdown table: COLOR, FREQ, TILE, wrap ratio,
accuracy of the substance, seconds of training.
"""

import argparse
from dataclasses import replace

import torch

from plan2scene.textures.model.texture_model import Architecture, low_precision_is_fast
from plan2scene_workshop.texture.data import join_sets, procedural_textures, scanned_textures
from plan2scene_workshop.texture.run import ARCHITECTURES, measure
from plan2scene_workshop.texture.settings import TextureSettings
from plan2scene_workshop.texture.training import train_texture_model

#: name: (changes of the architecture, changes of the training)
VARIANTS: dict[str, tuple[dict, dict]] = {
    "base": ({}, {}),
    "no_histogram_loss": ({}, {"histogram": 0.0}),
    "no_spectrum_loss": ({}, {"spectrum": 0.0, "frequency": 0.0}),
    "no_colour_loss": ({}, {"colour": 0.0, "histogram": 0.0}),
    "three_levels": ({}, {"levels": 3}),
    "code_4": ({"code_dim": 4}, {}),
    "code_32": ({"code_dim": 32}, {}),
    "rgb": ({"delta_hsv": False}, {}),
    "plane_noise": ({"periodic": False}, {}),
    "no_dropout": ({}, {"dropout": 0.0}),
    "resnet_encoder": ({"encoder": "resnet", "width": 16}, {}),
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--textures", required=True)
    parser.add_argument("--steps", type=int, default=600)
    parser.add_argument("--warm-up", type=int, default=2048)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", nargs="*", choices=sorted(VARIANTS), default=list(VARIANTS))
    options = parser.parse_args()
    torch.set_num_threads(1)
    textures = join_sets(
        procedural_textures(800, options.seed), scanned_textures(options.textures, "train")
    )
    held_out = scanned_textures(options.textures, "val")
    print("| variant | COLOR | FREQ | TILE | wrap | substance | s |\n|" + "---|" * 7)
    for name in options.only:
        architecture, training = VARIANTS[name]
        settings = TextureSettings(
            steps=options.steps,
            finish=options.steps // 10,
            warm_up=options.warm_up,
            warm_up_steps=options.warm_up * 3 // 8,
            **training,
        )
        settings = replace(settings, low_precision=low_precision_is_fast())
        shape: Architecture = replace(ARCHITECTURES["texture"], **architecture)
        trained = train_texture_model(shape, textures, settings, options.seed)
        model, seconds = trained.network, trained.seconds
        model.decoder.low_precision = False
        figures = measure(model, held_out, options.seed)
        row = (figures[k] for k in ("color", "freq", "tile", "wrap", "substance"))
        print(
            f"| {name} | " + " | ".join(f"{v:.3f}" for v in row) + f" | {seconds:.0f} |", flush=True
        )


if __name__ == "__main__":
    main()
