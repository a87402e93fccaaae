"""The part of the texture plane that each surface takes, in metres: what one image of it covers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plan2scene.house import SurfaceKey
from plan2scene.mesh.parts import MeshPart

#: Metres around a surface, so that filtering takes nothing of the far side.
MARGIN_M = 0.05


@dataclass(frozen=True)
class Area:
    """A rectangle of texture coordinates, metres: lower and upper corner (u, v)."""

    low: tuple[float, float]
    high: tuple[float, float]

    @property
    def size(self) -> tuple[float, float]:
        """Return width and height, metres."""
        return self.high[0] - self.low[0], self.high[1] - self.low[1]

    @property
    def square_m(self) -> float:
        """Return its area."""
        return self.size[0] * self.size[1]

    def union(self, other: Area) -> Area:
        """Return the least rectangle that holds both."""
        low, high = np.minimum(self.low, other.low), np.maximum(self.high, other.high)
        return Area((float(low[0]), float(low[1])), (float(high[0]), float(high[1])))


def areas_of(parts: Sequence[MeshPart]) -> dict[SurfaceKey, Area]:
    """Return the area of every surface that has faces, thresholds with the floor."""
    areas: dict[SurfaceKey, Area] = {}
    for part in parts:
        if part.surface is None or part.uv is None:
            continue
        low, high = part.uv.min(axis=0) - MARGIN_M, part.uv.max(axis=0) + MARGIN_M
        area = Area((float(low[0]), float(low[1])), (float(high[0]), float(high[1])))
        known = areas.get(part.surface)
        areas[part.surface] = area if known is None else known.union(area)
    return areas
