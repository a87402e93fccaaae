"""Text and signs on a drawn plan: rooms' names and sizes, chains of dimensions, titles, trees."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import shapely

from plan2scene_workshop.plans.room_names import NAMES
from plan2scene_workshop.plans.sheet import Sheet
from plan2scene_workshop.plans.structure import Structure
from plan2scene_workshop.plans.style import PlanStyle

_FOOT = 0.3048


def length_text(metres: float, unit: str, rng: np.random.Generator) -> str:
    """Return a length as text in one of the notations of drawings."""
    if unit == "ft":
        inches = round(metres / _FOOT * 12)
        feet, rest = divmod(inches, 12)
        return f"{feet}'{rest}\"" if rng.random() < 0.6 else f"{feet}' {rest}\""
    if unit == "mm":
        return str(round(metres * 1000))
    if unit == "cm":
        return str(round(metres * 100))
    text = f"{metres:.2f}"
    return text if rng.random() < 0.6 else text.replace(".", ",")


def area_text(square_metres: float, unit: str, rng: np.random.Generator) -> str:
    """Return an area as text in one of the notations of drawings."""
    if unit == "ft":
        return f"{round(square_metres / _FOOT**2)} {rng.choice(['sq ft', 'sq. ft', 'ft²'])}"
    digits = int(rng.choice([0, 1, 1, 2]))
    text = f"{square_metres:.{digits}f}"
    if rng.random() < 0.5:
        text = text.replace(".", ",")
    return text + str(rng.choice([" m²", "m²", " m2", "m2", " qm"]))


def name_rooms(sheet: Sheet, plan: Structure, style: PlanStyle, rng: np.random.Generator) -> None:
    """Write a name, an area, dimensions or several of them into each room."""
    if style.names == "none":
        return
    case = rng.choice(["plain", "upper", "lower"], p=[0.5, 0.35, 0.15])
    for room, types in zip(plan.rooms, plan.types, strict=True):
        inside = room.buffer(-plan.inner_depth / 2, join_style="mitre")
        if inside.is_empty or rng.random() < 0.06:
            continue
        lines = []
        if style.names != "areas" or rng.random() < 0.8:
            words = [str(rng.choice(NAMES[style.language][t].split("|"))) for t in types]
            name = "/".join(words)
            lines.append({"upper": name.upper(), "lower": name.lower()}.get(str(case), name))
        if style.names in ("areas", "both"):
            lines.append(area_text(inside.area, style.unit, rng))
        if style.names in ("dimensions", "both"):
            x0, z0, x1, z1 = inside.bounds
            cross = str(rng.choice([" x ", "x", " X ", " × "]))
            sides = [length_text(v, style.unit, rng) for v in (x1 - x0, z1 - z0)]
            lines.append(
                cross.join(sides) + (" m" if style.unit == "m" and rng.random() < 0.4 else "")
            )
        _write_lines(sheet, lines, inside, style, rng)


def _write_lines(
    sheet: Sheet,
    lines: list[str],
    inside: shapely.Geometry,
    style: PlanStyle,
    rng: np.random.Generator,
) -> None:
    """Write lines of text into a room, made smaller or turned upright to fit."""
    font = "sans" if style.language == "he" else style.font
    x0, z0, x1, z1 = inside.bounds
    spot = inside.representative_point()
    middle = np.array([spot.x, spot.y])
    if inside.area > 0.95 * (x1 - x0) * (z1 - z0):
        middle = np.array([(x0 + x1) / 2, (z0 + z1) / 2])
    middle = middle + rng.uniform(-0.12, 0.12, 2) * (x1 - x0, z1 - z0)
    longest = max(len(line) for line in lines)
    upright = (z1 - z0) > 1.4 * (x1 - x0) and longest * style.text_height * 0.8 > x1 - x0
    room = (z1 - z0) if upright else (x1 - x0)
    height = min(style.text_height, 1.25 * room / max(1, longest))
    height = max(height, 6 / sheet.ppm)
    for k, line in enumerate(lines):
        shift = (k - (len(lines) - 1) / 2) * height * 1.7
        offset = np.array([shift, 0.0]) if upright else np.array([0.0, shift])
        size = height * (1.0 if k == 0 else 0.9)
        sheet.write(line, middle + offset, size, style.pen, font, upright=upright)


def dimension_chains(
    sheet: Sheet, plan: Structure, style: PlanStyle, rng: np.random.Generator
) -> None:
    """Draw chains of dimensions outside the walls."""
    if style.chains == "none":
        return
    x0, z0, x1, z1 = shapely.union_all([plan.outer, plan.rails]).bounds
    xs, zs = _stops(plan)
    tick = str(rng.choice(["slash", "arrow", "dot", "bar"]))
    for axis, stops, (low, high) in ((0, xs, (z0, z1)), (1, zs, (x0, x1))):
        for side in (-1, 1):
            if rng.random() < 0.4:
                continue
            at = (low if side < 0 else high) + side * float(rng.uniform(0.35, 0.9))
            if style.chains == "steps":
                _chain(sheet, stops, axis, at, tick, style, rng)
                at += side * (style.text_height * 2 + 0.15)
            _chain(sheet, [stops[0], stops[-1]], axis, at, tick, style, rng)


def _stops(plan: Structure) -> tuple[list[float], list[float]]:
    """Return the positions of walls along x and along z, more than .5 m apart."""
    found = []
    for axis in (0, 1):
        values = sorted({round(p[axis], 2) for room in plan.rooms for p in room.exterior.coords})
        kept = values[:1]
        for value in values[1:]:
            if value - kept[-1] > 0.5:
                kept.append(value)
        found.append(kept)
    return found[0], found[1]


def _chain(
    sheet: Sheet,
    stops: list[float],
    axis: int,
    at: float,
    tick: str,
    style: PlanStyle,
    rng: np.random.Generator,
) -> None:
    """Draw one line of dimensions along an axis, with ticks and numbers."""

    def point(along: float, across: float) -> np.ndarray:
        return np.array([along, across] if axis == 0 else [across, along])

    sheet.line([point(stops[0], at), point(stops[-1], at)], style.accent, style.thin)
    t = style.text_height * 0.4
    for stop in stops:
        p = point(stop, at)
        if tick == "slash":
            sheet.line([p - (t, -t), p + (t, -t)], style.accent, style.thin)
        elif tick == "dot":
            sheet.fill(p + 0.4 * t * np.array([(1, 0), (0, 1), (-1, 0), (0, -1)]), style.accent)
        else:
            sheet.line([point(stop, at - t), point(stop, at + t)], style.accent, style.thin)
    for low, high in pairwise(stops):
        text = length_text(high - low, style.unit, rng)
        spot = point((low + high) / 2, at - style.text_height * 0.8)
        font = "sans" if style.font == "hand" and "'" in text else style.font
        sheet.write(text, spot, style.text_height * 0.8, style.accent, font, upright=axis == 1)


def surroundings(sheet: Sheet, plan: Structure, style: PlanStyle, rng: np.random.Generator) -> None:
    """Draw things beside a plan at random: a title, a frame, trees, arrows."""
    h, w = (np.array(sheet.image.shape[:2]) / sheet.ppm).tolist()
    x0, z0 = sheet.origin.tolist()
    font = "sans" if style.font == "hand" else style.font
    if rng.random() < 0.35:
        title = str(
            rng.choice(["GROUND FLOOR", "Wohnung 3", "Plan d'étage", "Planta baja", "First Floor"])
        )
        spot = (x0 + w * float(rng.uniform(0.2, 0.8)), z0 + float(rng.choice([0.05, 0.95])) * h)
        sheet.write(title, spot, style.text_height * float(rng.uniform(1.0, 2.0)), style.pen, font)
    if rng.random() < 0.15:
        sheet.line(
            [(x0 + 0.1, z0 + 0.1), (x0 + w - 0.1, z0 + 0.1), (x0 + w - 0.1, z0 + h - 0.1)]
            + [(x0 + 0.1, z0 + h - 0.1)],
            style.pen,
            style.thin,
            closed=True,
        )
    bounds = shapely.union_all([plan.outer, plan.rails])
    for _ in range(int(rng.integers(0, 4)) if rng.random() < 0.5 else 0):
        spot = np.array([x0, z0]) + rng.random(2) * (w, h)
        radius = float(rng.uniform(0.25, 0.9))
        if bounds.distance(shapely.Point(spot)) < radius or any(
            room.distance(shapely.Point(spot)) < radius for room in plan.rooms
        ):
            continue
        t = np.linspace(0, 2 * np.pi, 25)
        ring = np.c_[np.cos(t), np.sin(t)] * radius
        kind = rng.integers(4)
        if kind == 0:
            sheet.line(spot + ring, style.pen, style.thin)
            sheet.line([spot + ring[0], spot, spot + ring[8]], style.pen, style.thin)
        elif kind == 1:
            sheet.fill(spot + ring, style.tint)
        elif kind == 2:
            for k in range(0, 24, 2):
                sheet.line([spot, spot + ring[k]], style.pen, style.thin)
        else:
            sheet.fill(spot + ring[[0, 8, 16]] * 0.7, style.pen)
