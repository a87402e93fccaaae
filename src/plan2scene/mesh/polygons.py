"""Polygons with holes to triangles, with the area checked (trimesh with earcut)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry
from shapely.geometry.polygon import orient
from trimesh.creation import triangulate_polygon
from trimesh.grouping import unique_rows
from trimesh.triangles import cross

AREA_TOLERANCE = 1e-6  #: Relative error of a triangulation's area above which it is refused


def polygons_of(geometry: BaseGeometry, least_area: float = 1e-9) -> Iterator[Polygon]:
    """Yield the polygons in any geometry (lines, points and specks of area are left out)."""
    if isinstance(geometry, Polygon):
        if geometry.area > least_area:
            yield geometry
    elif hasattr(geometry, "geoms"):
        for part in geometry.geoms:
            yield from polygons_of(part, least_area)


def triangulate(geometry: BaseGeometry) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices (n, 2) float64 and faces (m, 3) int64 of a polygon or multi-polygon.

    Faces are counter-clockwise in the plane's (first, second) axis order. Raises ValueError when
    the triangles' area differs from the polygon's by more than `AREA_TOLERANCE`.
    """
    points, faces, count = [np.zeros((0, 2))], [np.zeros((0, 3), dtype=np.int64)], 0
    for polygon in polygons_of(geometry):
        corners, index = triangulate_polygon(orient(polygon), engine="earcut")
        unique, inverse = unique_rows(corners, keep_order=True)  # a ring repeats its first point
        corners, index = corners[unique], inverse[index]
        # Signed areas of the triangles: positive if counter-clockwise.
        areas = cross(np.pad(corners, ((0, 0), (0, 1)))[index])[:, 2] / 2
        total = float(np.abs(areas).sum())
        if abs(total - polygon.area) > AREA_TOLERANCE * max(polygon.area, 1e-3):
            raise ValueError(f"triangles of {total:.9f} m2 for a polygon of {polygon.area:.9f} m2")
        index = np.where((areas < 0)[:, None], index[:, ::-1], index)[np.abs(areas) > 1e-14]
        points.append(corners)
        faces.append(index + count)
        count += len(corners)
    return np.concatenate(points), np.concatenate(faces)
