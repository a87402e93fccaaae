"""What lies around a drawn plan without being part of it: notes, boundaries, paving, neighbours."""

from __future__ import annotations

import numpy as np
import shapely

from plan2scene_workshop.plans.sheet import Sheet
from plan2scene_workshop.plans.structure import Structure
from plan2scene_workshop.plans.style import PlanStyle

_NOTES = ("BH 700", "+0.00", "OK 2.40", "A", "1:100", "Nachbar", "REF.", "fenetre 90", "12")


def draw_clutter(sheet: Sheet, plan: Structure, style: PlanStyle, rng: np.random.Generator) -> None:
    """Draw some of it outside the walls."""
    home = shapely.union_all([plan.outer, plan.rails, *plan.rooms])
    x0, z0, x1, z1 = home.bounds
    if rng.random() < 0.25:
        _paving(sheet, home, style, rng)
    for _ in range(int(rng.integers(0, 3))):
        _boundary(sheet, home, style, rng)
    windows = [gap for gap in plan.gaps if gap.outer]
    for gap in windows:
        if rng.random() < 0.15:
            spot = (gap.start + gap.end) / 2 - gap.normal * (gap.depth / 2 + style.text_height)
            upright = abs(gap.normal[0]) > 0.5
            font = "sans" if style.font == "hand" else style.font
            text = str(rng.choice(_NOTES))
            sheet.write(text, spot, 0.7 * style.text_height, style.pen, font, upright=upright)
    if rng.random() < 0.12:
        corner = np.array([rng.choice([x0, x1]), rng.choice([z0, z1])])
        stub = corner + rng.uniform(-1.5, 1.5, 2)
        sheet.line(np.array([corner, (stub[0], corner[1]), stub]), style.ink, style.weight)


def _boundary(
    sheet: Sheet, home: shapely.Geometry, style: PlanStyle, rng: np.random.Generator
) -> None:
    """Draw a line of the site beside the walls, dashed or whole."""
    x0, z0, x1, z1 = home.bounds
    off = float(rng.uniform(0.25, 1.2))
    side = int(rng.integers(4))
    ends = [
        ((x0 - 2, z0 - off), (x1 + 2, z0 - off)),
        ((x0 - 2, z1 + off), (x1 + 2, z1 + off)),
        ((x0 - off, z0 - 2), (x0 - off, z1 + 2)),
        ((x1 + off, z0 - 2), (x1 + off, z1 + 2)),
    ][side]
    start, end = np.array(ends[0]), np.array(ends[1])
    if rng.random() < 0.5:
        sheet.dashes(start, end, style.pen, style.thin, float(rng.uniform(0.08, 0.3)))
    else:
        sheet.line([start, end], style.pen, style.thin)


def _paving(
    sheet: Sheet, home: shapely.Geometry, style: PlanStyle, rng: np.random.Generator
) -> None:
    """Draw a tinted or hatched area that touches the walls: a path, a lawn, the next flat."""
    x0, z0, x1, z1 = home.bounds
    w, h = rng.uniform(1.0, 4.0, 2)
    x, z = rng.uniform(x0 - w, x1), rng.choice([z0 - h * 0.8, z1 - h * 0.2])
    area = shapely.box(x, z, x + w, z + h).difference(home)
    if rng.random() < 0.5:
        sheet.fill_shape(area, style.tint)
    else:
        for part in np.arange(0, w + h, 0.2):
            line = shapely.LineString([(x + part, z), (x + part - h, z + h)]).intersection(area)
            for piece in shapely.get_parts(line):
                if piece.geom_type == "LineString":
                    sheet.line(np.array(piece.coords), style.pen, style.thin)
    if rng.random() < 0.5:
        sheet.outline(area, style.pen, style.thin)
