"""Curves and blocks of a DXF drawing as lines and areas in metres, (x, -y)."""

from __future__ import annotations

from typing import Any

import numpy as np
from shapely.geometry import LineString, Polygon, box

from plan2scene.plans.parse import Source

#: Most entities of a block, points of one curve, nesting of blocks.
MAX_ENTITIES = 100_000
MAX_POINTS = 2000
MAX_NESTING = 12
#: Curves are cut so that they stay this near (metres).
FLAT = 0.02
CURVES = ("LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE")


class Curves:
    """Reads the curves of a parsed document whose unit is `metres` long."""

    def __init__(self, source: Source, document: Any, metres: float) -> None:
        self.source, self.document, self.metres = source, document, metres
        self.boxes: dict[str, Polygon | None] = {}

    def line(self, entity: Any) -> LineString | None:
        """Return a curve in metres, (x, -y), closed ones with the first point repeated."""
        from ezdxf import path

        try:
            curve = path.make_path(entity)
            points = [(p.x, -p.y) for p in curve.flattening(FLAT / self.metres, 4)]
        except (TypeError, ValueError, ArithmeticError, AttributeError):
            return None
        if len(points) > MAX_POINTS:
            raise self.source.fault(f"at most {MAX_POINTS} points of a curve", len(points))
        array = np.array(points, dtype=np.float64).reshape(-1, 2) * self.metres
        if len(array) < 2 or not np.isfinite(array).all():
            return None
        closed = bool(getattr(entity, "is_closed", False) or getattr(entity, "closed", False))
        if (closed or np.hypot(*(array[0] - array[-1])) < 1e-3) and len(array) > 2:
            array = np.vstack(
                [array[:-1] if np.allclose(array[0], array[-1], atol=1e-3) else array, array[:1]]
            )
        return LineString(array)

    def block_area(self, insert: Any, depth: int = 0) -> Polygon | None:
        """Return the box around what an inserted block draws, as the insert turns it."""
        name = str(insert.dxf.get("name", ""))
        if name not in self.boxes:
            self.boxes[name] = None
            self.boxes[name] = self._block_box(name, depth)
        area = self.boxes[name]
        if area is None:
            return None
        m = insert.matrix44()
        corners = [m.transform((x, -y, 0)) for x, y in list(area.exterior.coords)[:4]]
        points = np.array([(p.x, -p.y) for p in corners]) * (self.metres if depth == 0 else 1.0)
        polygon = Polygon(points) if np.isfinite(points).all() else None
        return polygon if polygon is not None and polygon.area > 0 else None

    def _block_box(self, name: str, depth: int) -> Polygon | None:
        """Return the box around a block's curves in its own units, (x, -y)."""
        if depth > MAX_NESTING:
            raise self.source.fault(f"blocks at most {MAX_NESTING} deep", "deeper")
        bounds = []
        for count, entity in enumerate(self.document.blocks.get(name) or ()):
            if count >= MAX_ENTITIES:
                raise self.source.fault(f"at most {MAX_ENTITIES} entities of block {name}", "more")
            if entity.dxftype() == "INSERT":
                area = self.block_area(entity, depth + 1)
                bounds += [] if area is None else [area.bounds]
            elif entity.dxftype() in CURVES:
                line = self.line(entity)
                if line is not None:
                    bounds.append(tuple(v / self.metres for v in line.bounds))
        if not bounds:
            return None
        array = np.array(bounds)
        low, high = array[:, :2].min(axis=0), array[:, 2:].max(axis=0)
        return box(*low, *np.maximum(high, low + 1e-9))
