"""Ambient occlusion of a house's surfaces, baked into one image (glTF's occlusionTexture).

How much of the hemisphere over a point is free of what is nearer than `REACH_M`, weighted by the
cosine and by how near it is: corners, door frames and open leaves darken what is beside them; a
wall across the room does not. Rays by Embree.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from plan2scene.images import png_bytes
from plan2scene.mesh.charts import Chart, packed
from plan2scene.mesh.parts import MeshPart
from plan2scene.mesh.rays import Rays, hemisphere

#: What is farther away than this does not darken, metres.
REACH_M = 1.2
#: Side of a texel, metres; the image is at most `MOST_PX` wide and high, else texels are larger.
TEXEL_M = 0.08
MOST_PX = 2048
RAYS = 64


@dataclass(frozen=True)
class Occlusion:
    """A baked image, and where each part lies in it.

    Attributes
    ----------
    png : bytes
        (h, w) uint8, linear: 255 where nothing is near.
    uv : mapping of part name to (n, 2) float64
        Texture coordinates of the part's vertices in the image, v down, in [0, 1].
    """

    png: bytes
    uv: Mapping[str, np.ndarray]


def bake_occlusion(parts: Sequence[MeshPart], flat: Sequence[MeshPart]) -> Occlusion | None:
    """Return the occlusion of the `flat` ones among a house's parts, which have UV in metres.

    Every opaque part casts; glass does not, and skirting boards, thinner than a texel, would only
    blacken the wall behind them. None where nothing is flat, or where there is no ray
    tracer. Deterministic.
    """
    if not flat:
        return None
    rays = Rays.of([part for part in parts if part.extras.get("kind") != "skirting"])
    if rays is None:
        return None
    charts, (height, width) = packed(flat, TEXEL_M, MOST_PX)
    image = np.full((height, width), 255, np.uint8)
    uv = {}
    for chart in charts:
        _shade(image, chart, rays)
        uv[chart.part.name] = chart.texels(np.asarray(chart.part.uv)) / [width, height]
    return Occlusion(png_bytes(image), uv)


def _shade(image: np.ndarray, chart: Chart, rays: Rays) -> None:
    """Write a part's texels with their gutter into the image."""
    uv, inside = chart.grid()
    light = np.ones(inside.shape)
    if inside.any():
        light[inside] = _openness(chart, uv[inside], rays)
    chart.paste(image, np.round(255 * light).astype(np.uint8), inside)


def _openness(chart: Chart, uv: np.ndarray, rays: Rays) -> np.ndarray:
    """Return the free share of the hemisphere over points (n, 2) of a flat part, (n,) in [0, 1]."""
    directions = hemisphere(chart.normal, RAYS)
    points = chart.world(uv)
    origins = np.repeat(points, len(directions), axis=0)
    distance = rays.distances(origins, np.tile(directions, (len(points), 1)))
    near = np.clip(1 - distance / REACH_M, 0, 1).reshape(len(points), -1)
    return np.asarray(1 - near.mean(axis=1))
