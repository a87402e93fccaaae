"""What can be told of a plan whose scale is not known: how large it is drawn, layers of DXF."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plan2scene.floorplans.drawings.cubicasa import size_of_cubicasa
from plan2scene.floorplans.drawings.dxf_contents import DxfName, contents_of_dxf
from plan2scene.floorplans.parse import Source
from plan2scene.floorplans.r2v_text import parse_r2v


@dataclass(frozen=True)
class Unscaled:
    """A drawing in its own unit."""

    unit: str  #: pixel or unit
    size: tuple[float, float] | None = None  #: width and depth of what is drawn
    names: tuple[DxfName, ...] = ()


def unscaled_dxf(path: Path, house_id: str, layers: Mapping[str, str] | None) -> Unscaled:
    """Return the size and the layers of a DXF drawing."""
    names, size = contents_of_dxf(path, house_id, layers)
    return Unscaled("unit", size, tuple(names))


def unscaled_svg(content: bytes, house_id: str) -> Unscaled:
    """Return the size of an SVG plan."""
    return Unscaled("pixel", size_of_cubicasa(content, house_id))


def unscaled_r2v(text: str, house_id: str) -> Unscaled:
    """Return the size of raster-to-vector text by its walls."""
    walls = parse_r2v(Source("", house_id), text).walls
    if not walls:
        return Unscaled("pixel")
    width, depth = np.ptp([point for wall in walls for point in (wall.start, wall.end)], axis=0)
    return Unscaled("pixel", (float(width), float(depth)))
