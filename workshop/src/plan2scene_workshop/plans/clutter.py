"""Clutter around a drawn plan that is not part of it: notes, boundaries, paving, neighbours."""

from __future__ import annotations

import numpy as np
import shapely

from plan2scene_workshop.plans.sheet import Sheet
from plan2scene_workshop.plans.structure import Structure
from plan2scene_workshop.plans.style import PlanStyle

_NOTES = ("BH 700", "+0.00", "OK 2.40", "A", "1:100", "Nachbar", "REF.", "fenetre 90", "12")
_ROWS = ("Living 46.3", "Garage", "POOL", "Total 101 sqm", "TENNIS COURT", "Balkon 7,5")


def draw_clutter(sheet: Sheet, plan: Structure, style: PlanStyle, rng: np.random.Generator) -> None:
    """Draw random clutter outside the walls."""
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
    if rng.random() < 0.15:
        _neighbour(sheet, plan, home, style, rng)
    if rng.random() < 0.15:
        _table(sheet, home, style, rng)
    if rng.random() < 0.15:
        _logo(sheet, home, style, rng)
    if rng.random() < 0.08:  # the page's dark border
        size = np.array(sheet.image.shape[1::-1]) / sheet.ppm
        edge = float(rng.uniform(0.1, 0.5))
        page = shapely.box(*sheet.origin, *(sheet.origin + size))
        sheet.fill_shape(page.difference(page.buffer(-edge)), style.ink)


def _neighbour(
    sheet: Sheet,
    plan: Structure,
    home: shapely.Geometry,
    style: PlanStyle,
    rng: np.random.Generator,
) -> None:
    """Draw walls of a next flat or a stairwell that touch the left or right side of the home."""
    x0, z0, x1, z1 = home.bounds
    w, h = rng.uniform(2.0, 5.0, 2)
    x, z = rng.choice([x0 - w, x1]), float(rng.uniform(z0 - h / 2, z1 - h / 2))
    room = shapely.box(x, z, x + w, z + h)
    walls = room.difference(room.buffer(-plan.outer_depth)).difference(home.buffer(0.02))
    doors = shapely.box(x + w / 2, z - 1, x + w / 2 + 0.9, z + h + 1)
    sheet.fill_shape(walls.difference(doors), style.ink if rng.random() < 0.7 else style.tint)


def _free_spot(
    sheet: Sheet,
    home: shapely.Geometry,
    size: tuple[float, float],
    rng: np.random.Generator,
) -> np.ndarray | None:
    """Return the corner of a free area of `size` (width, height) in metres beside the home."""
    spare = np.array(sheet.image.shape[1::-1]) / sheet.ppm - size
    for _ in range(8):
        corner = sheet.origin + rng.random(2) * spare
        if (spare > 0).all() and not home.intersects(shapely.box(*corner, *(corner + size))):
            return np.asarray(corner)
    return None


def _table(
    sheet: Sheet, home: shapely.Geometry, style: PlanStyle, rng: np.random.Generator
) -> None:
    """Draw a table of areas; with one row it is a box with a name, like a pool or a court."""
    rows = int(rng.integers(1, 6))
    height = 2.0 * style.text_height
    width = float(rng.uniform(1.5, 4.0))
    corner = _free_spot(sheet, home, (width, rows * height), rng)
    if corner is None:
        return
    x, z = corner
    if rng.random() < 0.3:
        sheet.fill_shape(shapely.box(x, z, x + width, z + rows * height), style.tint)
    for row in range(rows):
        low, high = z + row * height, z + (row + 1) * height
        cell = np.array([(x, low), (x + width, low), (x + width, high), (x, high)])
        sheet.line(cell, style.pen, style.thin, closed=True)
        text = str(rng.choice(_ROWS))
        sheet.write(text, cell.mean(0), 0.8 * style.text_height, style.pen)


def _logo(sheet: Sheet, home: shapely.Geometry, style: PlanStyle, rng: np.random.Generator) -> None:
    """Draw an estate agent's logo: discs and boxes in random colours or ink."""
    corner = _free_spot(sheet, home, (1.2, 1.2), rng)
    if corner is None:
        return
    for k in range(int(rng.integers(1, 5))):
        colour = style.ink if rng.random() < 0.3 else tuple(int(v) for v in rng.integers(0, 256, 3))
        middle = corner + 0.3 + 0.6 * np.array([k % 2, k // 2])
        round_one = rng.random() < 0.5
        shape = shapely.Point(middle).buffer(0.28, cap_style="round" if round_one else "square")
        sheet.fill_shape(shape, colour)


def _boundary(
    sheet: Sheet, home: shapely.Geometry, style: PlanStyle, rng: np.random.Generator
) -> None:
    """Draw a boundary line of the site along one side of the home, dashed or solid."""
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
