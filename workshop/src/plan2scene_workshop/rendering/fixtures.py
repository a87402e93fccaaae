"""Doors, windows, and open curtains; closed blinds and curtains are in :mod:`.coverings`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plan2scene.photos.labels.palette import DOOR, WINDOW
from plan2scene.plans.wall_sides import FaceOpening
from plan2scene_workshop.rendering.coverings import wavy_sheet
from plan2scene_workshop.rendering.geometry import (
    Colour,
    Geometry,
    Solid,
    box,
    cylinder,
    merge,
    placement,
    quad,
)
from plan2scene_workshop.rendering.palette import Palette, pick
from plan2scene_workshop.rendering.shell import OUTER_REVEAL, WallFace

CASING_WIDTH, CASING_DEPTH = 0.065, 0.014
LEAF_THICKNESS = 0.04


@dataclass(frozen=True)
class DoorState:
    """The state of a door's leaf: `angle` in radians, 0 closed; `swings_in`: into this room."""

    angle: float
    hinge_left: bool
    swings_in: bool


def draw_door(rng: np.random.Generator, *, inner: bool) -> DoorState:
    """Draw the state of a leaf; doors to the outside are closed."""
    angle = float(np.radians(rng.uniform(65, 110))) if inner and rng.random() < 0.6 else 0.0
    return DoorState(angle, bool(rng.random() < 0.5), bool(rng.random() < 0.35))


def add_casing(geometry: Geometry, face: WallFace, hole: FaceOpening, colour: Colour) -> None:
    """Add the casing of a door on one face, and the half of its lining next to that face."""
    a, b, top, width = hole.left, hole.right, hole.top, CASING_WIDTH
    parts = [
        box((a - width, 0, 0), (a, top, CASING_DEPTH)),
        box((b, 0, 0), (b + width, top, CASING_DEPTH)),
        box((a - width, top, 0), (b + width, top + width, CASING_DEPTH)),
        box((a, 0, -face.inset), (a + 0.02, top, CASING_DEPTH)),
        box((b - 0.02, 0, -face.inset), (b, top, CASING_DEPTH)),
        box((a, top - 0.02, -face.inset), (b, top, CASING_DEPTH)),
    ]
    geometry.add("paint", merge(parts).moved(face.frame(0)), colour=colour, label=DOOR)


def _leaf(width: float, height: float, panels: int) -> Solid:
    """Return a door leaf in x 0..width, y, z about 0, with raised panels."""
    half = LEAF_THICKNESS / 2
    parts = [box((0, 0.005, -half), (width, height, half))]
    margin = 0.12
    for k in range(panels):
        low = margin + (height - margin) * k / panels
        high = margin + (height - margin) * (k + 1) / panels - margin
        parts.append(box((margin, low, -half - 0.006), (width - margin, high, half + 0.006)))
    return merge(parts)


def add_leaf(
    geometry: Geometry,
    face: WallFace,
    hole: FaceOpening,
    state: DoorState,
    look: tuple[str, Colour, int],
) -> None:
    """Add a leaf with handles. `look` is its material, colour and number of panels."""
    width = hole.right - hole.left - 0.045
    leaf = _leaf(width, hole.top - 0.025, look[2])
    handle_x, handle_y = width - 0.07, 1.02
    handles = merge(
        [
            box(
                (handle_x - 0.11, handle_y, side * 0.06 - 0.01),
                (handle_x, handle_y + 0.02, side * 0.06 + 0.01),
            )
            for side in (-1, 1)
        ]
        + [box((handle_x - 0.02, handle_y, -0.06), (handle_x, handle_y + 0.02, 0.06))]
    )
    depth = 0.0 if state.angle == 0 else (0.03 if state.swings_in else -2 * face.inset - 0.03)
    depth = -face.inset if state.angle == 0 else depth
    if state.hinge_left:
        base = placement(hole.left + 0.022, depth, -state.angle if state.swings_in else state.angle)
    else:
        turn = np.pi + (state.angle if state.swings_in else -state.angle)
        base = placement(hole.right - 0.022, depth, turn)
    matrix = face.frame(0) @ base
    geometry.add(look[0], leaf.moved(matrix), colour=look[1], label=DOOR)
    geometry.add("metal", handles.moved(matrix), label=DOOR)


def add_window(
    geometry: Geometry,
    face: WallFace,
    hole: FaceOpening,
    palette: Palette,
    rng: np.random.Generator,
    sky: str,
    drop: float,
) -> None:
    """Add frame, sill, the bright view outside (material `sky`), and sometimes a blind.

    `drop` is the share of the window that a roller blind covers.
    """
    frame = face.frame(0)
    a, b, low, top = hole.left, hole.right, hole.bottom, hole.top
    z0 = -face.inset - 0.55 * OUTER_REVEAL
    bar, deep = 0.055, 0.05
    parts = [
        box((a, low, z0 - deep), (a + bar, top, z0)),
        box((b - bar, low, z0 - deep), (b, top, z0)),
        box((a, top - bar, z0 - deep), (b, top, z0)),
        box((a, low, z0 - deep), (b, low + bar, z0)),
    ]
    panes = max(1, round((b - a) / rng.uniform(0.6, 1.1)))
    for k in range(1, panes):
        x = a + (b - a) * k / panes
        parts.append(box((x - 0.04, low, z0 - deep), (x + 0.04, top, z0)))
    if top - low > 1.0 and rng.random() < 0.3:
        y = low + (top - low) * rng.uniform(0.6, 0.75)
        parts.append(box((a, y - 0.025, z0 - deep), (b, y + 0.025, z0)))
    if low > 0.2:
        parts.append(box((a - 0.04, low - 0.03, -face.inset), (b + 0.04, low + 0.003, 0.05)))
    geometry.add("paint", merge(parts).moved(frame), colour=palette.frame, label=WINDOW)
    right = np.array([face.plane.right[0], 0.0, face.plane.right[1]])
    corner = face.at(a, top, -face.inset - OUTER_REVEAL + 0.01)
    down = np.array([0.0, low - top, 0.0])
    view = quad(corner, right * (b - a), down, (face.u_start + a, 3.0 - top))
    geometry.add(sky, view, label=WINDOW)
    if drop > 0:
        y = top - (top - low) * drop
        cloth = box((a + 0.01, y, -0.5 * face.inset - 0.004), (b - 0.01, top, -0.5 * face.inset))
        geometry.add("fabric", cloth.moved(frame), colour=pick(rng, palette.fabrics))


def add_curtains(
    geometry: Geometry,
    face: WallFace,
    hole: FaceOpening,
    material: str,
    colour: Colour,
    rng: np.random.Generator,
) -> None:
    """Add a rod and two open curtains at the sides of a window."""
    top = min(face.height - 0.06, hole.top + rng.uniform(0.08, 0.3))
    bottom = 0.03 if rng.random() < 0.75 else max(hole.bottom - 0.2, 0.03)
    cover = rng.uniform(0.08, 0.25) * (hole.right - hole.left)
    start = max(0.02, hole.left - rng.uniform(0.1, 0.3))
    end = min(face.length - 0.02, hole.right + rng.uniform(0.1, 0.3))
    frame = face.frame(0)
    for low, high in ((start, hole.left + cover), (hole.right - cover, end)):
        sheet = wavy_sheet(low, high, bottom, top, rng.uniform(0.08, 0.14))
        geometry.add(material, sheet.moved(frame), colour=colour)
    rod = cylinder((0, 0, 0), 0.013, end - start + 0.1, 8)
    lie = np.array(
        [[0, 1, 0, start - 0.05], [-1, 0, 0, top + 0.012], [0, 0, 1, 0.1], [0, 0, 0, 1.0]]
    )
    geometry.add("metal", rod.moved(frame @ lie))
