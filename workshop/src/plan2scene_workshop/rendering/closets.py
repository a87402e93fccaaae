"""Fitted closets: sliding or hinged fronts on a wall; their label is door."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from plan2scene.photos.labels.palette import DOOR
from plan2scene_workshop.rendering.geometry import Colour, Geometry, box, merge
from plan2scene_workshop.rendering.palette import WOODS, Palette, linear
from plan2scene_workshop.rendering.shell import WallFace

#: Probability that a wall that is long enough and has no opening gets a closet.
SHARE = 0.25
#: Smallest and largest width of a front, and its least distance from the wall's ends, metres.
_WIDTHS, _BESIDE = (0.9, 2.8), 0.12


def draw_leaf(rng: np.random.Generator, palette: Palette) -> tuple[str, Colour]:
    """Return material and colour of a leaf: wood, white, the home's door paint, or any paint."""
    kind = rng.random()
    if kind < 0.4:
        return str(rng.choice(WOODS)), palette.door
    if kind < 0.75:
        return "paint", linear(rng.uniform(0.05, 0.2), rng.uniform(0, 0.08), rng.uniform(0.75, 1))
    if kind < 0.9:
        return "paint", palette.door
    return "paint", linear(rng.random(), rng.uniform(0, 0.5), rng.uniform(0.1, 0.9))


def add_closets(
    geometry: Geometry, faces: Sequence[WallFace], palette: Palette, rng: np.random.Generator
) -> None:
    """Add the fronts of closets, some of them mirrors, to some walls without openings."""
    for face in faces:
        free = face.length - 2 * _BESIDE
        if face.openings or free < _WIDTHS[0] or rng.random() >= SHARE:
            continue
        width = float(rng.uniform(_WIDTHS[0], min(free, _WIDTHS[1])))
        left = _BESIDE + float(rng.choice([0.0, 1.0, rng.random()])) * (free - width)
        top = min(face.height - 0.05, rng.uniform(1.98, 2.12) if rng.random() < 0.7 else 9.0)
        leaves = max(2, round(width / rng.uniform(0.4, 1.0)))
        material, colour = draw_leaf(rng, palette)
        if rng.random() < 0.1:
            material = "mirror"
        slides, edges = rng.random() < 0.6, np.linspace(left, left + width, leaves + 1)
        for k, (a, b) in enumerate(pairwise(edges)):
            out = 0.012 + 0.02 * (k % 2) * slides
            leaf = box((a + 0.003, 0.012, 0.0), (b - 0.003, top, out))
            geometry.add(material, leaf.moved(face.frame(0)), colour=colour, label=DOOR)
            if not slides:
                knob = box((b - 0.06, 0.95, out), (b - 0.03, 1.05, out + 0.03))
                geometry.add("metal", knob.moved(face.frame(0)), label=DOOR)
        bar, deep = float(rng.uniform(0.02, 0.09)), 0.036
        end = left + width
        frame = [
            box((left - bar, 0, 0), (left, top + bar, deep)),
            box((end, 0, 0), (end + bar, top + bar, deep)),
            box((left, top, 0), (end, top + bar, deep)),
        ]
        geometry.add("paint", merge(frame).moved(face.frame(0)), colour=palette.trim, label=DOOR)
