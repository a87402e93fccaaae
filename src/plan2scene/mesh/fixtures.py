"""Doors and windows as simple parametric parts: frame, leaf with handle, mullions, panes, sill.

Sizes in metres are those of ordinary joinery; the opening gives width and height.
"""

from __future__ import annotations

import math

import numpy as np

from plan2scene.mesh.frames import Frame
from plan2scene.mesh.openings import Portal
from plan2scene.mesh.parts import Colour, MeshPart, PartBuilder

FRAME_COLOUR: Colour = (244, 242, 237)
LEAF_COLOUR: Colour = (236, 232, 224)
PANEL_COLOUR: Colour = (226, 221, 211)
ENTRANCE_COLOUR: Colour = (94, 64, 46)
ENTRANCE_PANEL_COLOUR: Colour = (82, 55, 39)
METAL_COLOUR: Colour = (150, 150, 152)
LINING_COLOUR: Colour = (238, 235, 229)

#: Inner doors stand open by this angle, so that one sees from room to room.
AJAR = math.radians(40.0)
FRAME_WIDTH = 0.05
LEAF_THICKNESS = 0.04
#: Doors wider than this have two leaves.
TWO_LEAVES = 1.25
#: A window has a mullion about every so many metres.
PANE_WIDTH = 0.9
#: Frames stand out of the wall by this much.
PROUD = 0.012
#: A frame is at least so deep, also where two rooms touch and the wall has no thickness.
LEAST_DEPTH = 0.09


def fixtures(portal: Portal) -> list[MeshPart]:
    """Return the parts of a door, window or passage (none when it is under 15 cm wide or high)."""
    hole = portal.hole
    if hole.right - hole.left < 0.15 or hole.top - hole.bottom < 0.15:
        return []
    if hole.opening.kind == "window":
        return _window(portal)
    return [_door(portal)]


def _centre(portal: Portal) -> np.ndarray:
    """Return the (4, 3) box frame at the hole's left edge, in the middle of the wall's depth.

    The far edge may stand askew: the frame follows the owner's side.
    """
    return portal.side.frame.axes(portal.hole.left, -portal.depth / 2)


def _depth(portal: Portal) -> float:
    """Return how far a frame reaches to both sides of the middle of the wall."""
    return max(portal.depth / 2 + PROUD, LEAST_DEPTH / 2)


def _surround(
    builder: PartBuilder, portal: Portal, width: float, colour: Colour, *, sill: bool
) -> None:
    """Add the frame: two jambs, the head, and for a window the bottom piece."""
    frame, half = _centre(portal), _depth(portal)
    size, low, high = portal.width, portal.hole.bottom, portal.hole.top
    builder.box(frame, np.array([0, low, -half]), np.array([width, high, half]), colour)
    builder.box(frame, np.array([size - width, low, -half]), np.array([size, high, half]), colour)
    inner = np.array([width, high - width, -half]), np.array([size - width, high, half])
    builder.box(frame, *inner, colour)
    if sill:
        inner = np.array([width, low, -half]), np.array([size - width, low + width, half])
        builder.box(frame, *inner, colour)


def _door(portal: Portal) -> MeshPart:
    """Return a door's frame and leaves, or a passage's lining."""
    builder = PartBuilder()
    room, opening = portal.side.room_id, portal.hole.opening
    extras = {"kind": opening.kind, "room_id": room, "opening_id": opening.id}
    if portal.other is not None:
        extras["leads_to"] = portal.other
    if opening.kind == "passage":
        _surround(builder, portal, 0.015, LINING_COLOUR, sill=False)
        return builder.build(f"{room}/passage/{opening.id}", extras=extras)
    width = portal.width
    jamb = min(FRAME_WIDTH, width * 0.12)
    _surround(builder, portal, jamb, FRAME_COLOUR, sill=False)
    gap = 0.004
    clear = width - 2 * (jamb + gap)
    top = portal.hole.top - jamb - gap
    leaves = ((jamb + gap, 1.0, clear),)
    if width > TWO_LEAVES:
        half = clear / 2 - gap / 2
        leaves = ((jamb + gap, 1.0, half), (width - jamb - gap, -1.0, half))  # type: ignore[assignment]
    for hinge, turn, size in leaves:
        _leaf(builder, portal, hinge, turn, (size, portal.hole.bottom + 0.008, top))
    return builder.build(f"{room}/door/{opening.id}", extras=extras)


def _leaf(
    builder: PartBuilder,
    portal: Portal,
    hinge: float,
    turn: float,
    size: tuple[float, float, float],
) -> None:
    """Add a door leaf hinged at `hinge` metres; `turn` is +1 when it extends to the right.

    `size` is (width, bottom, top). Doors to the outside are shut.
    """
    width, low, high = size
    outside = portal.other is None
    colour, panel = (
        (ENTRANCE_COLOUR, ENTRANCE_PANEL_COLOUR) if outside else (LEAF_COLOUR, PANEL_COLOUR)
    )
    base = _centre(portal)
    angle = 0.0 if outside else AJAR
    inward = base[2]
    along = turn * base[0] * math.cos(angle) + inward * math.sin(angle)
    across = np.cross(along, base[1])
    frame = np.array([along, base[1], across, base[3] + hinge * base[0]])
    if not outside:  # the pivot is at the room's face of the frame, so the leaf clears the jamb
        frame[3] += inward * (_depth(portal) - LEAF_THICKNESS)
    half = LEAF_THICKNESS / 2
    builder.box(frame, np.array([0, low, -half]), np.array([width, high, half]), colour)
    margin, middle = width * 0.16, low + (high - low) * 0.45
    for bottom, top in ((low + 0.18, middle - 0.05), (middle + 0.05, high - 0.14)):
        if top - bottom > 0.1 and width > 0.3:
            raised = half + 0.006
            builder.box(
                frame,
                np.array([margin, bottom, -raised]),
                np.array([width - margin, top, raised]),
                panel,
            )
    grip = low + min(1.03, (high - low) * 0.5)
    for side in (-1.0, 1.0):
        near, far = sorted((side * half, side * (half + 0.05)))
        builder.box(
            frame,
            np.array([width - 0.085, grip - 0.012, near]),
            np.array([width - 0.06, grip + 0.012, far]),
            METAL_COLOUR,
        )
        near, far = sorted((side * (half + 0.035), side * (half + 0.05)))
        builder.box(
            frame,
            np.array([width - 0.19, grip - 0.012, near]),
            np.array([width - 0.06, grip + 0.012, far]),
            METAL_COLOUR,
        )


def _window(portal: Portal) -> list[MeshPart]:
    """Return a window's frame with mullions, transom and sill board, and its glass."""
    builder, glass = PartBuilder(), PartBuilder()
    room, opening = portal.side.room_id, portal.hole.opening
    width, low, high = portal.width, portal.hole.bottom, portal.hole.top
    bar = min(FRAME_WIDTH, 0.12 * min(width, high - low))
    _surround(builder, portal, bar, FRAME_COLOUR, sill=True)
    frame = _centre(portal)
    count = max(1, round((width - bar) / PANE_WIDTH))
    for k in range(1, count):
        s = width * k / count
        builder.box(
            frame,
            np.array([s - bar / 2, low + bar, -0.03]),
            np.array([s + bar / 2, high - bar, 0.03]),
            FRAME_COLOUR,
        )
    if high - low > 1.6:  # a tall window has its upper lights apart
        y = high - 0.25 * (high - low)
        builder.box(
            frame,
            np.array([bar, y - bar / 2, -0.025]),
            np.array([width - bar, y + bar / 2, 0.025]),
            FRAME_COLOUR,
        )
    if low > 0.3:
        reach = _depth(portal)
        builder.box(
            frame,
            np.array([-0.03, low - 0.03, 0.0]),
            np.array([width + 0.03, low, reach + 0.04]),
            FRAME_COLOUR,
        )
    pane = Frame(
        portal.side.frame.plan(portal.hole.left, -portal.depth / 2),
        portal.side.frame.right,
        portal.side.frame.normal,
        width,
    )
    corners = np.array(
        [[bar, low + bar], [width - bar, low + bar], [width - bar, high - bar], [bar, high - bar]]
    )
    glass.quad(pane.world(corners), (255, 255, 255))
    extras = {"kind": "window", "room_id": room, "opening_id": opening.id}
    name = f"{room}/window/{opening.id}"
    return [
        builder.build(name, extras=extras),
        glass.build(f"{name}/glass", "glass", extras={**extras, "kind": "glass"}),
    ]
