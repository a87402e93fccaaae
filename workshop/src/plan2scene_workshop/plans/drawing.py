"""Draws a synthetic home as a picture of a plan, with the label of every pixel."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
import shapely
import shapely.affinity

from plan2scene.house import House
from plan2scene_app.tracing.settings import DOOR, LABEL_OF_TYPE, OUTSIDE, PASSAGE, WALL, WINDOW
from plan2scene_workshop.plans.clutter import draw_clutter
from plan2scene_workshop.plans.furnish import furnish
from plan2scene_workshop.plans.lettering import dimension_chains, name_rooms, surroundings
from plan2scene_workshop.plans.openings import draw_gap
from plan2scene_workshop.plans.sheet import Sheet
from plan2scene_workshop.plans.structure import Structure, structure_of
from plan2scene_workshop.plans.style import PlanStyle

_GAP_LABELS = {"door": DOOR, "window": WINDOW, "passage": PASSAGE}
#: Range of the margins around a plan in metres.
MARGIN_M = (0.6, 2.4)


@dataclass(frozen=True)
class DrawnPlan:
    """A drawing and its truth."""

    image: np.ndarray  #: (h, w, 3) uint8 sRGB
    labels: np.ndarray  #: (h, w) uint8 of `PLAN_LABELS`
    plan: Structure
    ppm: float  #: pixels per metre
    origin: tuple[float, float]  #: (x, z) of the picture's corner in metres


def draw_plan(
    house: House, style: PlanStyle, ppm: float, rng: np.random.Generator, *, finer: int = 2
) -> DrawnPlan:
    """Return a drawing of a house at `ppm` pixels per metre, drawn `finer` times larger first."""
    plan = structure_of(
        house,
        rng,
        inner_depth=style.inner_depth,
        outer_depth=style.outer_depth,
        rail_depth=style.rail_depth,
        cut_corners=style.cut_corners,
        opened=style.opened,
        windows=style.window != "none",
    )
    x0, z0, x1, z1 = shapely.union_all([plan.outer, plan.rails, *plan.rooms]).bounds
    low, high = MARGIN_M
    high += 1.0 if style.chains != "none" else 0.0
    margins = rng.uniform(low, high, 4)
    origin = (x0 - margins[0], z0 - margins[1])
    size = (
        round((z1 + margins[2] - origin[1]) * ppm),
        round((x1 + margins[3] - origin[0]) * ppm),
    )
    sheet = Sheet((size[0] * finer, size[1] * finer), ppm * finer, origin, style.paper)
    _draw(sheet, plan, style, rng)
    image = cv2.resize(sheet.image, (size[1], size[0]), interpolation=cv2.INTER_AREA)
    labels = plan_labels(plan, size, ppm, origin)
    return DrawnPlan(image, labels, plan, ppm, origin)


def _draw(sheet: Sheet, plan: Structure, style: PlanStyle, rng: np.random.Generator) -> None:
    """Draw everything, from the lowest layer to the topmost."""
    _floors(sheet, plan, style, rng)
    surroundings(sheet, plan, style, rng)
    draw_clutter(sheet, plan, style, rng)
    if style.furniture != "none":
        furnish(sheet, plan, style, rng)
    _walls(sheet, plan, style, rng)
    for gap in plan.gaps:
        draw_gap(sheet, gap, style, rng)
    name_rooms(sheet, plan, style, rng)
    dimension_chains(sheet, plan, style, rng)


def plan_labels(
    plan: Structure, size: tuple[int, int], ppm: float, origin: tuple[float, float]
) -> np.ndarray:
    """Return the labels (h, w) uint8; walls and openings are at least 3 pixels thick."""
    sheet = Sheet((1, 1), ppm, origin, (0, 0, 0))
    labels = np.full(size, OUTSIDE, np.uint8)
    least = 3.0 / ppm
    for room, types in zip(plan.rooms, plan.types, strict=True):
        sheet.mark(labels, room, LABEL_OF_TYPE[types[0]])
    for body in (plan.rails, plan.inner, plan.outer):
        sheet.mark(labels, body, WALL)
    gaps = shapely.union_all([shapely.Polygon(g.corners(g.depth + 0.02)) for g in plan.gaps])
    lines = shapely.union_all([room.exterior for room in plan.rooms])
    if plan.outer_depth > least:  # outer walls lie mostly outside the outline
        lines = lines.difference(plan.outer.buffer(0.01))
    sheet.mark(labels, lines.buffer(least / 2, cap_style="flat").difference(gaps), WALL)
    for gap in plan.gaps:
        area = shapely.Polygon(gap.corners(max(gap.depth, least)))
        sheet.mark(labels, area, _GAP_LABELS[gap.kind])
    return labels


def _floors(sheet: Sheet, plan: Structure, style: PlanStyle, rng: np.random.Generator) -> None:
    """Paint floors: none, in one colour, in one per room type, or with a pattern in some rooms."""
    if style.floor == "none":
        return
    tints = {}
    for room, types in zip(plan.rooms, plan.types, strict=True):
        if style.floor == "one":
            sheet.fill_shape(room, style.tint)
            continue
        if style.floor in ("by_type", "gradient"):
            if types[0] not in tints:
                shift = rng.integers(-40, 41, 3)
                tints[types[0]] = tuple(
                    int(v) for v in np.clip(np.array(style.tint) + shift, 0, 255)
                )
            sheet.fill_shape(room, tints[types[0]])
        if style.floor == "gradient":
            place = sheet.window(room)
            mask = sheet.mask(room)[place]
            ramp = np.linspace(0.75, 1.1, mask.shape[1])[None, :, None]
            shaded = np.clip(sheet.image[place] * ramp, 0, 255).astype(np.uint8)
            sheet.image[place] = np.where(mask[..., None], shaded, sheet.image[place])
        wet = types[0] in ("Bathroom", "Kitchen", "Balcony", "Terrace")
        if rng.random() < (0.7 if wet else 0.25):
            _pattern(sheet, room, style, rng, wet=wet)


def _pattern(
    sheet: Sheet,
    room: shapely.Polygon,
    style: PlanStyle,
    rng: np.random.Generator,
    *,
    wet: bool,
) -> None:
    """Draw tiles (in wet rooms) or boards on the floor of a room."""
    place = sheet.window(room)
    size = sheet.image[place].shape[:2]
    x0, z0, x1, z1 = room.bounds
    step = float(rng.uniform(0.18, 0.45))
    other = Sheet(size, sheet.ppm, (x0 - 1 / sheet.ppm, z0 - 1 / sheet.ppm), (0, 0, 0))
    ink = (255, 255, 255)
    for x in np.arange(x0, x1, step):
        other.line([(x, z0), (x, z1)], ink)
    if wet:
        for z in np.arange(z0, z1, step):
            other.line([(x0, z), (x1, z)], ink)
    part = other.image[..., :1] / np.float32(255) * other.mask(room)[..., None]
    part *= float(rng.uniform(0.15, 0.6))
    pen = np.array(style.pen, np.float32)
    sheet.image[place] = (sheet.image[place] * (1 - part) + pen * part).astype(np.uint8)


def _walls(sheet: Sheet, plan: Structure, style: PlanStyle, rng: np.random.Generator) -> None:
    """Draw the walls in the style of the drawing."""
    _rails(sheet, plan, style)
    if style.wall == "line":
        gaps = shapely.union_all([shapely.Polygon(g.corners(g.depth + 0.1)) for g in plan.gaps])
        weight = max(1, round(style.weight * sheet.ppm / 35))
        lines = shapely.union_all(
            [r.exterior for k, r in enumerate(plan.rooms) if plan.indoor(k)]
        ).difference(gaps)
        for part in shapely.get_parts(shapely.line_merge(lines)):
            sheet.line(np.array(part.coords), style.ink, weight)
        return
    if style.wall == "mixed":
        sheet.fill_shape(plan.outer, style.ink)
        middles = shapely.union_all([room.exterior for room in plan.rooms])
        for part in shapely.get_parts(shapely.line_merge(middles.intersection(plan.inner))):
            sheet.line(np.array(part.coords), style.pen, style.thin)
        return
    bodies = shapely.union_all([plan.inner, plan.outer])
    if rng.random() < 0.06:  # the walls' shadow on the floors
        dark = sheet.mask(shapely.affinity.translate(bodies, 0.08, 0.08))[..., None]
        sheet.image[:] = np.where(dark, sheet.image // 4 * 3, sheet.image)
    kinds = {"solid": style.ink, "grey": (int(rng.integers(90, 200)),) * 3}
    if style.wall in kinds:
        sheet.fill_shape(bodies, kinds[style.wall])
        if style.wall == "grey" and rng.random() < 0.5:
            sheet.outline(bodies, style.ink, style.thin)
        return
    light = rng.random() < 0.4
    sheet.fill_shape(bodies, style.tint if light and style.wall != "double" else style.paper)
    if style.wall in ("hatched", "crossed", "dotted", "bricks"):
        _hatch(sheet, bodies, style, rng)
    if style.wall == "hatched" and rng.random() < 0.4:
        sheet.fill_shape(plan.inner, style.ink if rng.random() < 0.5 else style.paper)
        sheet.outline(plan.inner, style.ink, style.thin)
    sheet.outline(bodies, style.ink, style.weight + (2 if style.wall == "hollow_thick" else 0))


def _rails(sheet: Sheet, plan: Structure, style: PlanStyle) -> None:
    """Draw the rails of balconies and terraces: an outline, a line, dashes, or only posts."""
    if style.rail == "outline":
        sheet.fill_shape(plan.rails, style.paper)
        sheet.outline(plan.rails, style.pen, style.thin)
        return
    air = [room.exterior for k, room in enumerate(plan.rooms) if not plan.indoor(k)]
    lines = shapely.union_all(air).intersection(plan.rails)
    for part in shapely.get_parts(shapely.line_merge(lines)):
        points = np.array(part.coords)
        if style.rail == "line":
            sheet.line(points, style.pen, style.thin)
            continue
        for start, end in pairwise(points):
            if style.rail == "dashed":
                sheet.dashes(start, end, style.pen, style.weight, 0.15)
            else:
                sheet.fill_shape(shapely.Point(start).buffer(0.15, cap_style="square"), style.ink)


def _hatch(
    sheet: Sheet, bodies: shapely.Geometry, style: PlanStyle, rng: np.random.Generator
) -> None:
    """Fill bodies with lines at 45 degrees, crossed ones, dots or bricks."""
    h, w = sheet.image.shape[:2]
    columns, rows = np.meshgrid(np.arange(w), np.arange(h))
    step = max(4, round(float(rng.uniform(0.06, 0.18)) * sheet.ppm))
    inked = (columns + rows) % step < max(1, style.thin)
    if style.wall == "crossed":
        inked |= (columns - rows) % step < max(1, style.thin)
    elif style.wall == "dotted":
        inked = ((columns % step) < 2) & ((rows % step) < 2)
    elif style.wall == "bricks":
        shifted = columns + (rows // step % 2) * step
        inked = (rows % step < 1) | (shifted % (2 * step) < 1)
    sheet.image[inked & sheet.mask(bodies)] = style.ink
