"""Furniture-like clutter."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from ...house import Room
from .geometry import Geometry
from .palette import Palette
from .shell import WallFace


def furnish_room(
    geometry: Geometry,
    room: Room,
    faces: tuple[WallFace, ...],
    palette: Palette,
    rng: np.random.Generator,
    cameras: Sequence[shapely.Point],
) -> None:
    """Furnish."""
