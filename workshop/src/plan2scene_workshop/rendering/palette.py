"""Colours and textures of furniture, joinery and pictures in a house."""

from __future__ import annotations

import colorsys
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plan2scene.materials import random_material
from plan2scene.seeds import derive_seed, generator
from plan2scene_workshop.rendering.geometry import Colour
from plan2scene_workshop.rendering.tracer import Finish

#: Names of the textured finishes that every house has, by use.
WOODS = ("wood0", "wood1")
FABRICS = ("fabric0", "fabric1", "fabric2")
STONES = ("stone0",)
RUGS = ("rug0", "rug1")
PICTURES = ("picture0", "picture1", "picture2")


@dataclass(frozen=True)
class Palette:
    """The colours of one house, linear RGB."""

    trim: Colour
    door: Colour
    frame: Colour
    fabrics: tuple[Colour, ...]
    furniture: tuple[Colour, ...]
    accents: tuple[Colour, ...]
    plants: tuple[Colour, ...]


def linear(hue: float, saturation: float, value: float) -> Colour:
    """Return linear RGB (by gamma 2.2) of an HSV colour."""
    red, green, blue = colorsys.hsv_to_rgb(hue % 1.0, saturation, value)
    return (red**2.2, green**2.2, blue**2.2)


def draw_palette(rng: np.random.Generator) -> Palette:
    """Draw a palette: whites and woods for joinery, muted fabrics, a few strong accents."""

    def joinery() -> Colour:
        if rng.random() < 0.7:
            return linear(rng.uniform(0.05, 0.2), rng.uniform(0, 0.06), rng.uniform(0.82, 0.96))
        if rng.random() < 0.6:
            return linear(rng.uniform(0.05, 0.1), rng.uniform(0.35, 0.65), rng.uniform(0.3, 0.75))
        return linear(rng.random(), rng.uniform(0, 0.2), rng.uniform(0.15, 0.6))

    def fabric() -> Colour:
        return linear(rng.random(), rng.uniform(0.02, 0.4), rng.uniform(0.2, 0.85))

    def furniture() -> Colour:
        if rng.random() < 0.5:
            return linear(rng.uniform(0.05, 0.12), rng.uniform(0.0, 0.1), rng.uniform(0.6, 0.95))
        if rng.random() < 0.6:
            return linear(rng.uniform(0.04, 0.1), rng.uniform(0.3, 0.7), rng.uniform(0.2, 0.7))
        return linear(rng.random(), rng.uniform(0.0, 0.4), rng.uniform(0.05, 0.7))

    return Palette(
        linear(rng.uniform(0.05, 0.2), rng.uniform(0, 0.05), rng.uniform(0.85, 0.97))
        if rng.random() < 0.75
        else joinery(),
        joinery(),
        joinery(),
        tuple(fabric() for _ in range(5)),
        tuple(furniture() for _ in range(5)),
        tuple(
            linear(rng.random(), rng.uniform(0.15, 0.75), rng.uniform(0.2, 0.9)) for _ in range(6)
        ),
        tuple(
            linear(rng.uniform(0.2, 0.38), rng.uniform(0.4, 0.8), rng.uniform(0.2, 0.55))
            for _ in range(3)
        ),
    )


def clutter_finishes(house_id: str, seed: int) -> dict[str, Finish]:
    """Return the textured finishes of furniture, rugs and pictures, and the plain finishes.

    `paint`, `gloss` and `fabric` have a colour per face; `metal` and `mirror` are metallic.
    """
    finishes = {
        "paint": Finish(roughness=0.5),
        "gloss": Finish(roughness=0.15),
        "fabric": Finish(roughness=1.0),
        "metal": Finish(np.full((2, 2, 3), 205, np.uint8), roughness=0.3, metallic=True),
        "mirror": Finish(np.full((2, 2, 3), 240, np.uint8), roughness=0.02, metallic=True),
    }
    for names, substance in ((WOODS, "wood"), (FABRICS, "carpet"), (STONES, "tile")):
        for name in names:
            made = random_material(
                substance,
                derive_seed(seed, house_id, "clutter", name),
                kind={"wood": "plain", "carpet": None, "tile": "marble"}[substance],
                size_px=128,
            )
            rough = 1.0 if substance == "carpet" else 0.35
            size = made.size_m * (0.5 if substance == "carpet" else 1.0)
            finishes[name] = Finish(made.albedo, size, rough)
    for name in RUGS:
        rng = generator(seed, house_id, "clutter", name)
        finishes[name] = Finish(pattern(rng, 96), float(rng.uniform(0.6, 2.4)), 1.0)
    for name in PICTURES:
        finishes[name] = Finish(_picture(generator(seed, house_id, "clutter", name)), 1.0, 0.3)
    return finishes


def pattern(rng: np.random.Generator, size: int) -> NDArray[np.uint8]:
    """Return a periodic pattern of stripes, checks or waves in two to four colours."""
    colours = np.array(
        [
            [c * 255 for c in colorsys.hsv_to_rgb(rng.random(), rng.uniform(0, 0.7), v)]
            for v in rng.uniform(0.2, 0.95, 4)
        ]
    )
    y, x = np.mgrid[:size, :size] / size
    a, b = rng.integers(1, 5, 2)
    wave = np.sin(2 * np.pi * (a * x)) * (rng.random() < 0.7)
    wave = wave + np.sin(2 * np.pi * (b * y)) * (rng.random() < 0.7)
    wave = wave + 0.5 * np.sin(2 * np.pi * (a * x + b * y + 0.2 * np.sin(2 * np.pi * x)))
    index = np.clip(((wave + 2) / 4 * len(colours)).astype(int), 0, len(colours) - 1)
    image = colours[index] + rng.normal(0, 7, (size, size, 1))
    return np.clip(image, 0, 255).astype(np.uint8)


def _picture(rng: np.random.Generator) -> NDArray[np.uint8]:
    """Return an abstract picture: a gradient with blobs and bars."""
    size = 96
    y, x = np.mgrid[:size, :size] / size
    top, bottom = rng.uniform(30, 250, (2, 3))
    image = top + (bottom - top) * y[..., None]
    for _ in range(int(rng.integers(3, 12))):
        colour = rng.uniform(20, 240) + rng.normal(0, 35, 3)
        cx, cy = rng.random(2)
        w, h = rng.uniform(0.03, 0.35, 2)
        if rng.random() < 0.5:
            inside = ((x - cx) / w) ** 2 + ((y - cy) / h) ** 2 < 1
        else:
            inside = (np.abs(x - cx) < w) & (np.abs(y - cy) < h)
        image[inside] = colour
    return np.clip(image, 0, 255).astype(np.uint8)


def pick(rng: np.random.Generator, options: tuple[Colour, ...]) -> Colour:
    """Return one of the colours."""
    return options[int(rng.integers(len(options)))]
