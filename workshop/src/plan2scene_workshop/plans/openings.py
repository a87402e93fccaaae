"""Symbols of doors, windows and passages in the gaps of a drawn plan's walls."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from plan2scene_workshop.plans.sheet import Sheet
from plan2scene_workshop.plans.structure import Gap
from plan2scene_workshop.plans.style import PlanStyle

_Draw = Callable[[Sheet, Gap, PlanStyle, np.random.Generator], None]


def draw_gap(sheet: Sheet, gap: Gap, style: PlanStyle, rng: np.random.Generator) -> None:
    """Draw the symbol of an opening into the gap that the wall already has."""
    registry, name = {
        "door": (_DOORS, style.outer_door if gap.outer else style.door),
        "window": (_WINDOWS, style.window),
        "passage": (_PASSAGES, style.passage),
    }[gap.kind]
    if gap.kind == "door" and gap.width > 1.25:
        name = "sliding" if rng.random() < 0.5 else "double_leaf"
    registry[name](sheet, gap, replace(style, door=name) if gap.kind == "door" else style, rng)


def _arc(
    sheet: Sheet, hinge: np.ndarray, along: np.ndarray, out: np.ndarray, angle: float = 90
) -> list[np.ndarray]:
    """Return the arc of a leaf's tip from `along` (in the wall's line) by `angle` towards `out`.

    Both vectors have the leaf's length.
    """
    t = np.deg2rad(np.linspace(0, angle, 17))[:, None]
    return list(hinge + np.cos(t) * along + np.sin(t) * out)


def _leaf(gap: Gap, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the hinge, and the vectors of the closed leaf and of the leaf open at 90 degrees."""
    hinge, other = (gap.start, gap.end) if rng.random() < 0.5 else (gap.end, gap.start)
    side = gap.normal if not gap.outer or rng.random() < 0.8 else -gap.normal
    base = hinge + side * gap.depth / 2 * float(rng.choice([0.0, 1.0]))
    return base, other - hinge, side * gap.width


def _door_arc(sheet: Sheet, gap: Gap, style: PlanStyle, rng: np.random.Generator) -> None:
    hinge, closed, opened = _leaf(gap, rng)
    weight = style.weight if style.door == "arc" else style.thin
    swing = _arc(sheet, hinge, closed, opened, style.swing)
    sheet.line([hinge, swing[-1]], style.pen, weight)
    if style.door == "double_arc":
        shift = 0.05 * closed / gap.width
        sheet.line([hinge + shift, swing[-1] + shift], style.pen, weight)
    if style.door == "filled_arc":
        sheet.fill([hinge, *swing], style.tint)
    if style.door == "dashed_arc":
        for a, b in zip(swing[:-1:2], swing[1::2], strict=False):
            sheet.line([a, b], style.pen, style.thin)
    else:
        sheet.line(swing, style.pen, style.thin)


def _door_leaf(sheet: Sheet, gap: Gap, style: PlanStyle, rng: np.random.Generator) -> None:
    hinge, closed, opened = _leaf(gap, rng)
    tip = opened
    if style.door == "slanted":
        tip = (closed * 0.7 + opened * 0.7) * float(rng.uniform(0.9, 1.05))
    sheet.line([hinge, hinge + tip], style.pen, style.weight)


def _door_gap(sheet: Sheet, gap: Gap, style: PlanStyle, rng: np.random.Generator) -> None:
    if rng.random() < 0.3:
        corners = gap.corners()
        sheet.line(corners[[0, 1]], style.pen, style.thin)
        sheet.line(corners[[2, 3]], style.pen, style.thin)


def _door_box(sheet: Sheet, gap: Gap, style: PlanStyle, rng: np.random.Generator) -> None:
    sheet.line(gap.corners(), style.pen, style.thin, closed=True)
    if rng.random() < 0.5:
        _door_arc(sheet, gap, style, rng)


def _sliding(sheet: Sheet, gap: Gap, style: PlanStyle, rng: np.random.Generator) -> None:
    middle = (gap.start + gap.end) / 2
    lift = gap.normal * min(gap.depth, 0.16) / 4
    overlap = (gap.end - gap.start) * 0.05
    sheet.line([gap.start + lift, middle + lift + overlap], style.pen, style.weight)
    sheet.line([middle - lift - overlap, gap.end - lift], style.pen, style.weight)


def _double_leaf(sheet: Sheet, gap: Gap, style: PlanStyle, rng: np.random.Generator) -> None:
    middle = (gap.start + gap.end) / 2
    side = gap.normal if rng.random() < 0.7 else -gap.normal
    for hinge in (gap.start, gap.end):
        swing = _arc(sheet, hinge, middle - hinge, side * gap.width / 2, style.swing)
        sheet.line([hinge, swing[-1]], style.pen, style.weight)
        sheet.line(swing, style.pen, style.thin)


def _along(gap: Gap, share: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the ends of the line through the gap at `share` of its depth, in [-.5, .5]."""
    shift = gap.normal * gap.depth * share
    return gap.start + shift, gap.end + shift


def _frame(sheet: Sheet, gap: Gap, style: PlanStyle, weight: int) -> None:
    sheet.line(gap.corners(), style.accent, weight, closed=True)


def _window_lines(sheet: Sheet, gap: Gap, style: PlanStyle, rng: np.random.Generator) -> None:
    for share in np.linspace(-0.5, 0.5, int(rng.integers(2, 5))):
        sheet.line(_along(gap, float(share)), style.accent, style.thin)


def _window_pane(sheet: Sheet, gap: Gap, style: PlanStyle, rng: np.random.Generator) -> None:
    _frame(sheet, gap, style, style.thin)
    sheet.line(_along(gap, 0.0), style.accent, style.thin)
    if rng.random() < 0.3:
        middle = (gap.start + gap.end) / 2
        half = gap.normal * gap.depth / 2
        sheet.line([middle - half, middle + half], style.accent, style.thin)


def _window_filled(sheet: Sheet, gap: Gap, style: PlanStyle, rng: np.random.Generator) -> None:
    sheet.fill(gap.corners(), style.tint if rng.random() < 0.6 else style.paper)
    _frame(sheet, gap, style, style.thin)


def _window_sill(sheet: Sheet, gap: Gap, style: PlanStyle, rng: np.random.Generator) -> None:
    share = float(rng.uniform(0.0, 0.5))
    for s in (-share, share) if rng.random() < 0.7 else (0.0,):
        sheet.line(_along(gap, s), style.accent, style.thin)
    outer = -gap.normal * (gap.depth / 2 + 0.06)
    edge = (gap.end - gap.start) / gap.width * 0.08
    sheet.line([gap.start + outer - edge, gap.end + outer + edge], style.accent, style.thin)


def _window_ticks(sheet: Sheet, gap: Gap, style: PlanStyle, rng: np.random.Generator) -> None:
    sheet.line(_along(gap, 0.0), style.accent, style.weight)
    half = gap.normal * gap.depth * 0.6
    for point in (gap.start, gap.end):
        sheet.line([point - half, point + half], style.accent, style.weight)


def _window_swing(sheet: Sheet, gap: Gap, style: PlanStyle, rng: np.random.Generator) -> None:
    _frame(sheet, gap, style, style.thin)
    leaf = gap.width if gap.width < 1.0 else gap.width / 2
    along = (gap.end - gap.start) / gap.width * leaf
    swing = _arc(sheet, gap.start, along, gap.normal * leaf)
    sheet.line([gap.start, *swing[::-1]], style.pen, style.thin)


def _window_gap(sheet: Sheet, gap: Gap, style: PlanStyle, rng: np.random.Generator) -> None:
    if rng.random() < 0.5:
        sheet.dashes(*_along(gap, 0.0), style.accent, style.thin, 0.06)


def _window_line(sheet: Sheet, gap: Gap, style: PlanStyle, rng: np.random.Generator) -> None:
    sheet.line(_along(gap, 0.0), style.accent, style.thin)


def _window_niche(sheet: Sheet, gap: Gap, style: PlanStyle, rng: np.random.Generator) -> None:
    low, high = -0.5, float(rng.uniform(-0.35, 0.0))
    for share in (low, (low + high) / 2, high):
        sheet.line(_along(gap, share), style.accent, style.thin)
    if rng.random() < 0.5:
        middle = (gap.start + gap.end) / 2
        ends = [middle + gap.normal * gap.depth * share for share in (low, high)]
        sheet.line(ends, style.accent, style.thin)
    if rng.random() < 0.5:
        sheet.line(_along(gap, 0.5), style.accent, style.thin)


def _window_cross(sheet: Sheet, gap: Gap, style: PlanStyle, rng: np.random.Generator) -> None:
    _frame(sheet, gap, style, style.thin)
    corners = gap.corners()
    sheet.line(corners[[0, 2]], style.accent, style.thin)
    sheet.line(corners[[1, 3]], style.accent, style.thin)


def _window_thick(sheet: Sheet, gap: Gap, style: PlanStyle, rng: np.random.Generator) -> None:
    _frame(sheet, gap, style, style.weight + 1)


def _passage_gap(sheet: Sheet, gap: Gap, style: PlanStyle, rng: np.random.Generator) -> None:
    """Leave the gap as it is."""


def _passage_dashed(sheet: Sheet, gap: Gap, style: PlanStyle, rng: np.random.Generator) -> None:
    for share in (-0.5, 0.5):
        sheet.dashes(*_along(gap, share), style.pen, style.thin)


def _passage_dotted(sheet: Sheet, gap: Gap, style: PlanStyle, rng: np.random.Generator) -> None:
    sheet.dashes(*_along(gap, 0.0), style.pen, style.thin, 0.05)


def _passage_line(sheet: Sheet, gap: Gap, style: PlanStyle, rng: np.random.Generator) -> None:
    sheet.line(_along(gap, 0.0), style.pen, style.thin)


def _passage_lines(sheet: Sheet, gap: Gap, style: PlanStyle, rng: np.random.Generator) -> None:
    for share in (-0.5, 0.5):
        sheet.line(_along(gap, share), style.pen, style.thin)


_DOORS: dict[str, _Draw] = {
    "arc": _door_arc,
    "thin_arc": _door_arc,
    "dashed_arc": _door_arc,
    "double_arc": _door_arc,
    "filled_arc": _door_arc,
    "leaf": _door_leaf,
    "slanted": _door_leaf,
    "gap": _door_gap,
    "box": _door_box,
    "sliding": _sliding,
    "double_leaf": _double_leaf,
}
_WINDOWS: dict[str, _Draw] = {
    "lines": _window_lines,
    "pane": _window_pane,
    "filled": _window_filled,
    "sill": _window_sill,
    "ticks": _window_ticks,
    "swing": _window_swing,
    "gap": _window_gap,
    "line": _window_line,
    "niche": _window_niche,
    "cross": _window_cross,
    "thick_frame": _window_thick,
}
_PASSAGES: dict[str, _Draw] = {
    "gap": _passage_gap,
    "dashed": _passage_dashed,
    "dotted": _passage_dotted,
    "line": _passage_line,
    "lines": _passage_lines,
}
