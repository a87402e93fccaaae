"""Places on floors and walls from which things of drawn rooms are built."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plan2scene.photos.labels.palette import OTHER
from plan2scene_workshop.segmentation.bodies import (
    Array,
    Body,
    Paint,
)


@dataclass(frozen=True, eq=False)
class Spot:
    """A place on the floor with a heading; makes parts given in its own frame (y up, z front)."""

    x: float
    z: float
    yaw: float

    def world(self, centre: Sequence[float]) -> Array:
        """Return a point of this frame in the world, (3,) float64."""
        cos, sin = np.cos(self.yaw), np.sin(self.yaw)
        x, y, z = centre
        return np.array([self.x + cos * x + sin * z, y, self.z - sin * x + cos * z])

    def at(self, x: float, z: float, turn: float = 0.0) -> Spot:
        """Return another place, given in this frame."""
        place = self.world((x, 0.0, z))
        return Spot(float(place[0]), float(place[2]), self.yaw + turn)

    def part(
        self,
        centre: Sequence[float],
        size: Sequence[float] | Array,
        paint: Paint,
        *,
        round: bool = False,
        glow: float = 0.0,
        label: int = OTHER,
        turn: float = 0.0,
        tilt: float = 0.0,
        stencil: Array | None = None,
        mirror: float = 0.0,
    ) -> Body:
        """Return a box (or ellipsoid) of full `size` at `centre`, both metres in this frame."""
        half = np.maximum(np.array(size, float) / 2, 0.004)
        return Body(
            self.world(centre),
            half,
            self.yaw + turn,
            (label,),
            (paint,),
            round=round,
            glow=glow,
            tilt=tilt,
            stencil=stencil,
            mirror=mirror,
        )


def wall_spots(half: Array) -> list[tuple[Spot, float]]:
    """Return the middle of each wall at the floor, facing the room, and the wall's length."""
    spots = []
    for axis in (0, 2):
        for sign in (-1, 1):
            yaw = {0: -sign * np.pi / 2, 2: np.pi * (sign > 0)}[axis]
            place = [0.0, 0.0]
            place[axis // 2] = sign * float(half[axis])
            spots.append((Spot(place[0], place[1], float(yaw)), 2 * float(half[2 - axis])))
    return spots
