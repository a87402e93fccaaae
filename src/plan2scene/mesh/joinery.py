"""Doors and windows as simple parametric parts: frame, leaf with handle, mullions, panes, sill.

Sizes in metres are those of ordinary joinery; the opening gives width and height.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely

from plan2scene.colour import (
    as_float,
    as_uint8,
    is_wood,
    linear_to_srgb,
    rgb_to_lab,
    srgb_to_linear,
)
from plan2scene.house import Room
from plan2scene.mesh.parts import Colour, MeshPart, PartBuilder
from plan2scene.plans.room_names import is_garage
from plan2scene.plans.wall_sides import Portal
from plan2scene.seeds import generator

FRAME_COLOUR: Colour = (244, 242, 237)
LEAF_COLOUR: Colour = (236, 232, 224)
#: Panels of a leaf have its colour times this (sRGB).
PANEL_SHADE = 0.955
METAL_COLOUR: Colour = (150, 150, 152)
LINING_COLOUR: Colour = (238, 235, 229)
#: Rooms of these types have doors of glass to a balcony or terrace.
GLAZED = frozenset({"Reception", "Bedroom", "Kitchen"})


@dataclass(frozen=True)
class JoinerySizes:
    """Sizes of ordinary joinery, metres; angles in radians."""

    #: Inner doors stand wide open, as in photos of homes for sale. Chosen on two real flats
    #: (development): views from the photos' places are nearer to the photos than with 0 or 40.
    wide_open: float = math.radians(80.0)
    #: Where a wall is in the way, they are opened less, in steps of this.
    less_open: float = math.radians(10.0)
    frame: float = 0.05  #: width of a frame
    leaf: float = 0.04  #: thickness of a leaf
    two_leaves: float = 1.25  #: wider doors have two leaves
    sections: float = 2.2  #: wider doors to the outside are garage doors, unless of glass
    section: float = 0.5  #: approximate height of a section of a garage door
    pane: float = 0.9  #: approximate distance of a window's mullions
    proud: float = 0.012  #: frames stand out of the wall by this much
    least_depth: float = 0.09  #: least depth of a frame, also if the wall has no thickness
    low_sill: float = 0.3  #: windows with a sill below this have no sill board, no upper lights


JOINERY = JoinerySizes()


@dataclass(frozen=True)
class Veneer:
    """Grain of a leaf of bare wood: upright streaks, as straight-grained veneer has.

    Chosen by looking at doors of two real flats (development) and the demo.
    """

    streak: tuple[float, float] = (0.003, 0.014)  #: width, metres
    contrast: float = 0.07  #: standard deviation of a streak's log reflectance
    figure: float = 0.05  #: amplitude of the broad figure behind the streaks, log reflectance


VENEER = Veneer()


def fixtures(
    portal: Portal,
    leaf: Colour = LEAF_COLOUR,
    trim: Colour | None = None,
    *,
    inwards: bool = True,
    swept: shapely.Polygon | None = None,
    hatch: bool = False,
    glazed: bool = False,
) -> list[MeshPart]:
    """Return the parts of a door, window or passage (none when it is under 15 cm wide or high).

    `leaf` is the colour of a door's leaves, `trim` that of frames and linings. Leaves open into the
    portal's room if `inwards`, else into the other; `swept` is the floor (x, z) of the room that
    they open into, in metres: they are opened as far as its walls let them. A `hatch` is a window
    between two rooms: lining and board, no glass. A `glazed` door is built as a window, shut. A
    passage up to the ceiling has no parts.
    """
    hole = portal.hole
    if hole.right - hole.left < 0.15 or hole.top - hole.bottom < 0.15:
        return []
    if hole.opening.kind == "passage" and portal.side.wall.full(hole.opening):
        return []
    if hole.opening.kind == "window" or glazed:
        return _window(portal, trim or FRAME_COLOUR, hatch=hatch)
    return [_door(portal, leaf, trim, 1.0 if inwards else -1.0, swept)]


def is_hatch(portal: Portal, indoors: Collection[str]) -> bool:
    """Return whether an opening is a window between two rooms that are `indoors` (ids)."""
    window = portal.hole.opening.kind == "window"
    return window and portal.side.room_id in indoors and portal.other in indoors


def is_glazed(portal: Portal, rooms: Mapping[str, Room]) -> bool:
    """Return whether a door of one of the `rooms` (by id) is of glass.

    It is if it joins a room of a `GLAZED` type and one in the open air. A door to the outside is if
    it has two leaves and its room is `GLAZED` or in the open air, or if it is wider than
    `JOINERY.sections` (it slides) and its room is no garage.
    """
    if portal.hole.opening.kind != "door":
        return False
    joined = [rooms[room] for room in (portal.side.room_id, portal.other) if room is not None]
    indoors = [room for room in joined if not room.open_air]
    lived_in = any(GLAZED & set(room.types) for room in indoors)
    if portal.other is not None:
        return len(indoors) == 1 and lived_in
    slides = portal.width > JOINERY.sections and not is_garage(joined[0].title)
    return portal.width > JOINERY.two_leaves and (lived_in or not indoors or slides)


def _centre(portal: Portal) -> np.ndarray:
    """Return the (4, 3) box frame at the hole's left edge, in the middle of the wall's depth.

    The far edge may be askew; the frame is parallel to the owner's side.
    """
    return portal.side.frame.axes(portal.hole.left, -portal.depth / 2)


def _depth(portal: Portal) -> float:
    """Return how far a frame reaches to either side of the middle of the wall, metres."""
    return max(portal.depth / 2 + JOINERY.proud, JOINERY.least_depth / 2)


def _extras(portal: Portal) -> dict[str, str]:
    """Return what viewers show about the parts of an opening."""
    opening = portal.hole.opening
    extras = {"kind": opening.kind, "room_id": portal.side.room_id, "opening_id": opening.id}
    return extras if portal.other is None else {**extras, "leads_to": portal.other}


def _surround(
    builder: PartBuilder, portal: Portal, width: float, colour: Colour, *, sill: bool
) -> None:
    """Add the frame: two jambs, the head, and for a window the bottom piece."""
    frame, half = _centre(portal), _depth(portal)
    size, low, high = portal.width, portal.hole.bottom, portal.hole.top
    builder.box(frame, (0, low, -half), (width, high, half), colour)
    builder.box(frame, (size - width, low, -half), (size, high, half), colour)
    builder.box(frame, (width, high - width, -half), (size - width, high, half), colour)
    if sill:
        builder.box(frame, (width, low, -half), (size - width, low + width, half), colour)


def _door(
    portal: Portal,
    leaf: Colour,
    trim: Colour | None,
    swing: float,
    swept: shapely.Polygon | None,
) -> MeshPart:
    """Return a door's frame and leaves, or a passage's lining.

    The leaves open into the portal's room where `swing` is 1, into the other where it is -1. A
    single leaf has its hinge on the side where it opens farther; see :func:`fixtures` for `swept`.
    """
    builder, extras = PartBuilder(), _extras(portal)
    room, opening = portal.side.room_id, portal.hole.opening
    if opening.kind == "passage":
        _surround(builder, portal, 0.015, trim or LINING_COLOUR, sill=False)
        return builder.build(f"{room}/passage/{opening.id}", extras=extras)
    width = portal.width
    jamb = min(JOINERY.frame, width * 0.12)
    _surround(builder, portal, jamb, trim or FRAME_COLOUR, sill=False)
    gap = 0.004
    clear = width - 2 * (jamb + gap)
    low, high = portal.hole.bottom + 0.008, portal.hole.top - jamb - gap
    if portal.other is None and width > JOINERY.sections:
        _sections(builder, portal, (jamb + gap, clear), (low, high), leaf)
        return builder.build(f"{room}/door/{opening.id}", extras=extras)
    hinges = [(jamb + gap, 1.0), (width - jamb - gap, -1.0)]
    paired = width > JOINERY.two_leaves
    if paired:
        clear = clear / 2 - gap / 2
    angles = [_opened(portal, hinge, (side, swing), clear, swept) for hinge, side in hinges]
    best = int(angles[1] > angles[0])
    for k in (0, 1) if paired else (best,):
        hinge, side = hinges[k]
        _leaf(builder, portal, hinge, (side, swing), (clear, low, high), angles[k], leaf)
    return builder.build(f"{room}/door/{opening.id}", extras=extras)


def _sections(
    builder: PartBuilder,
    portal: Portal,
    across: tuple[float, float],
    up: tuple[float, float],
    colour: Colour,
) -> None:
    """Add a shut garage door: sections above each other, with dark joints between them.

    `across` is (left, width), `up` is (bottom, top).
    """
    (left, width), (low, high) = across, up
    frame, half = _centre(portal), JOINERY.leaf / 2
    red, green, blue = (round(PANEL_SHADE * value) for value in colour)
    ends = (left, low, 0.006 - half), (left + width, high, half - 0.006)
    builder.box(frame, *ends, (red, green, blue))
    edges = np.linspace(low, high, max(1, round((high - low) / JOINERY.section)) + 1)
    for bottom, top in pairwise(edges.tolist()):
        ends = (left, bottom + 0.005, -half), (left + width, top - 0.005, half)
        builder.box(frame, *ends, colour)


def _leaf_frame(
    portal: Portal, hinge: float, turn: tuple[float, float], angle: float
) -> np.ndarray:
    """Return the (4, 3) box frame of a leaf that is hinged at `hinge` metres.

    `turn` is two signs: +1 if the leaf extends to the right, +1 if it opens into the portal's room.
    `angle` is by how much it is open, radians.
    """
    base = _centre(portal)
    inward = turn[1] * base[2]
    along = turn[0] * base[0] * math.cos(angle) + inward * math.sin(angle)
    across = np.cross(along, base[1])
    frame = np.array([along, base[1], across, base[3] + hinge * base[0]])
    if portal.other is not None:  # the pivot is at the face of the frame: the leaf clears the jamb
        frame[3] += inward * (_depth(portal) - JOINERY.leaf)
    return frame


def _opened(
    portal: Portal,
    hinge: float,
    turn: tuple[float, float],
    width: float,
    swept: shapely.Polygon | None,
) -> float:
    """Return the angle by which a leaf of a `width` is open, radians; doors outwards are shut.

    `hinge` and `turn` are those of :func:`_leaf_frame`, `swept` that of :func:`fixtures`.
    """
    if portal.other is None:
        return 0.0
    angle = JOINERY.wide_open
    while swept is not None and angle > JOINERY.less_open:
        along, _, _, pivot = _leaf_frame(portal, hinge, turn, angle)
        outer = [(pivot + share * width * along)[[0, 2]] for share in (0.5, 1.0)]
        if swept.covers(shapely.LineString(outer)):
            break
        angle -= JOINERY.less_open
    return angle


def _leaf(
    builder: PartBuilder,
    portal: Portal,
    hinge: float,
    turn: tuple[float, float],
    size: tuple[float, float, float],
    angle: float,
    colour: Colour,
) -> None:
    """Add a door leaf; `hinge`, `turn` and `angle` are those of :func:`_leaf_frame`.

    `size` is (width, bottom, top).
    """
    width, low, high = size
    frame = _leaf_frame(portal, hinge, turn, angle)
    half = JOINERY.leaf / 2
    if is_wood(rgb_to_lab(as_float(np.array(colour, np.uint8)))):
        _veneer(builder, frame, (width, low, high), colour)
    else:
        builder.box(frame, (0, low, -half), (width, high, half), colour)
        _panels(builder, frame, (width, low, high), colour)
    grip = low + min(1.03, (high - low) * 0.5)
    for side in (-1.0, 1.0):
        for left, right, start, end in ((0.085, 0.06, 0.0, 0.05), (0.19, 0.06, 0.035, 0.05)):
            near, far = sorted((side * (half + start), side * (half + end)))
            builder.box(
                frame,
                (width - left, grip - 0.012, near),
                (width - right, grip + 0.012, far),
                METAL_COLOUR,
            )


def _panels(
    builder: PartBuilder, frame: np.ndarray, size: tuple[float, float, float], colour: Colour
) -> None:
    """Add the two panels of a leaf of (width, bottom, top)."""
    width, low, high = size
    red, green, blue = (round(PANEL_SHADE * value) for value in colour)
    margin, middle = width * 0.16, low + (high - low) * 0.45
    for bottom, top in ((low + 0.18, middle - 0.05), (middle + 0.05, high - 0.14)):
        if top - bottom > 0.1 and width > 0.3:
            raised = JOINERY.leaf / 2 + 0.006
            ends = (margin, bottom, -raised), (width - margin, top, raised)
            builder.box(frame, *ends, (red, green, blue))


def _veneer(
    builder: PartBuilder, frame: np.ndarray, size: tuple[float, float, float], colour: Colour
) -> None:
    """Add a flush leaf of (width, bottom, top) with a grain of lighter and darker streaks."""
    width, low, high = size
    rng = generator(0, "veneer", *colour, *(round(value, 3) for value in size))
    edges = np.cumsum(rng.uniform(*VENEER.streak, math.ceil(width / VENEER.streak[0])))
    edges = np.concatenate([[0.0], edges[edges < width - VENEER.streak[0]], [width]])
    log = rng.normal(0.0, VENEER.contrast, len(edges))
    log += VENEER.figure * np.sin(edges / width * rng.uniform(6.0, 12.0) + rng.uniform(0.0, 6.0))
    linear = srgb_to_linear(np.array(colour, np.uint8)) * np.exp(log - log.mean())[:, None]
    shades = as_uint8(linear_to_srgb(linear))
    half = JOINERY.leaf / 2
    builder.box(frame, (0, low, 0.001 - half), (width, high, half - 0.001), colour)
    for z in (half, -half):
        points = np.array([[x, y, z] for x in edges for y in (low, high)])
        first = np.arange(0, 2 * len(edges) - 2, 2)[:, None]
        faces = np.concatenate([first + [0, 2, 3], first + [0, 3, 1]])
        turned = faces if z > 0 else faces[:, ::-1]
        builder.mesh(points @ frame[:3] + frame[3], turned, colour=np.repeat(shades, 2, axis=0))


def _window(portal: Portal, colour: Colour, *, hatch: bool) -> list[MeshPart]:
    """Return the frame of a window or glazed door, with mullions and sill board, and its glass."""
    builder, glass, extras = PartBuilder(), PartBuilder(), _extras(portal)
    width, low, high = portal.width, portal.hole.bottom, portal.hole.top
    bar = min(JOINERY.frame, 0.12 * min(width, high - low))
    _surround(builder, portal, 0.015 if hatch else bar, colour, sill=True)
    frame = _centre(portal)
    if low > JOINERY.low_sill:
        reach, back = _depth(portal) + 0.04, -_depth(portal) - 0.04 if hatch else 0.0
        builder.box(frame, (-0.03, low - 0.03, back), (width + 0.03, low, reach), colour)
    name = f"{portal.side.room_id}/{portal.hole.opening.kind}/{portal.hole.opening.id}"
    if hatch:
        return [builder.build(name, extras=extras)]
    count = max(1, round((width - bar) / JOINERY.pane))
    for k in range(1, count):
        s = width * k / count
        builder.box(frame, (s - bar / 2, low + bar, -0.03), (s + bar / 2, high - bar, 0.03), colour)
    if high - low > 1.6 and low > JOINERY.low_sill:  # a bar below the upper lights of a tall window
        y = high - 0.25 * (high - low)
        builder.box(frame, (bar, y - bar / 2, -0.025), (width - bar, y + bar / 2, 0.025), colour)
    (x0, y0), (x1, y1) = (bar, low + bar), (width - bar, high - bar)
    pane = np.array([[x0, y0, 0], [x1, y0, 0], [x1, y1, 0], [x0, y1, 0]])
    glass.quad(pane @ frame[:3] + frame[3], (255, 255, 255))
    return [
        builder.build(name, extras=extras),
        glass.build(f"{name}/glass", "glass", extras={**extras, "kind": "glass"}),
    ]
