"""Polygons with holes to triangles, with the area checked (shapely, earcut)."""

from __future__ import annotations

from collections.abc import Iterator

import mapbox_earcut as earcut
import numpy as np
import shapely
from shapely.geometry import MultiPolygon, Polygon
from shapely.geometry.base import BaseGeometry
from shapely.geometry.polygon import orient

from plan2scene.errors import InputError
from plan2scene.house import Room

#: Relative error of a triangulation's area above which it is refused.
AREA_TOLERANCE = 1e-6


def polygons_of(geometry: BaseGeometry, least_area: float = 1e-9) -> Iterator[Polygon]:
    """Yield the polygons in any geometry (lines, points and specks of area are left out)."""
    if isinstance(geometry, Polygon):
        if geometry.area > least_area:
            yield geometry
    elif hasattr(geometry, "geoms"):
        for part in geometry.geoms:
            yield from polygons_of(part, least_area)


def room_polygon(room: Room) -> MultiPolygon:
    """Return a room's outline less its holes, valid, in (x, z) metres.

    The readers refuse self-intersecting outlines; what is left for ``make_valid`` here is a hole
    that touches the outline and repeated points.

    Raises
    ------
    InputError
        When nothing with an area is left.
    """
    outline, *holes = (Polygon(ring) for ring in room.rings)
    outline = outline if outline.is_valid else shapely.make_valid(outline)
    if holes:
        inner = shapely.unary_union([h if h.is_valid else shapely.make_valid(h) for h in holes])
        outline = outline.difference(inner)
    parts = list(polygons_of(outline))
    if not parts:
        raise InputError("a room outline with an area", "none", room=room.id)
    return MultiPolygon(parts)


def triangulate(geometry: BaseGeometry) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices (n, 2) float64 and faces (m, 3) int64 of a polygon or multi-polygon.

    Faces are counter-clockwise in the plane's (first, second) axis order. Raises ValueError when
    the triangles' area differs from the polygon's by more than `AREA_TOLERANCE`.
    """
    points: list[np.ndarray] = []
    faces: list[np.ndarray] = []
    count = 0
    for polygon in polygons_of(geometry):
        polygon = orient(polygon)
        rings = [np.asarray(ring.coords)[:-1] for ring in (polygon.exterior, *polygon.interiors)]
        flat = np.concatenate(rings).astype(np.float64)
        ends = np.cumsum([len(ring) for ring in rings]).astype(np.uint32)
        index = earcut.triangulate_float64(flat, ends).reshape(-1, 3).astype(np.int64)
        index = _counter_clockwise(flat, index)
        area = float(np.abs(signed_areas(flat, index)).sum())
        if abs(area - polygon.area) > AREA_TOLERANCE * max(polygon.area, 1e-3):
            raise ValueError(f"triangles of {area:.9f} m2 for a polygon of {polygon.area:.9f} m2")
        points.append(flat)
        faces.append(index + count)
        count += len(flat)
    if not points:
        return np.zeros((0, 2)), np.zeros((0, 3), dtype=np.int64)
    return np.concatenate(points), np.concatenate(faces)


def signed_areas(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the (m,) signed areas of 2-D triangles, positive when counter-clockwise."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    first, second = b - a, c - a
    return (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / 2


def _counter_clockwise(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return faces with clockwise ones turned over and zero-area ones left out."""
    area = signed_areas(points, faces)
    faces = np.where((area < 0)[:, None], faces[:, ::-1], faces)
    return faces[np.abs(area) > 1e-14]
