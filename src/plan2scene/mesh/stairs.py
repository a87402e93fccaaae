"""Stairs between levels with their handrails and wells, and railings of wells and balconies."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from shapely.geometry import LineString, Polygon
from shapely.geometry.base import BaseGeometry
from shapely.ops import unary_union

from plan2scene.house import House, Stairs
from plan2scene.mesh.fittings import WOOD
from plan2scene.mesh.parts import Colour, MeshPart, PartBuilder
from plan2scene.mesh.structure import REVEAL_COLOUR
from plan2scene.plans.geometry import room_polygon
from plan2scene.plans.levels import flight_area, step_count
from plan2scene.plans.wall_sides import LIFT, Frame, Side, frame_between

COLOUR: Colour = (82, 84, 86)


@dataclass(frozen=True)
class RailingSizes:
    """Ordinary sizes of railings, metres; no child fits through the gap."""

    height: float = 1.05
    post: float = 0.045
    bar: float = 0.014
    rail: float = 0.035
    gap: float = 0.11
    bay: float = 1.2  #: approximate distance of posts
    beside_wall: float = 0.1  #: an edge of a well this near to a wall has no railing
    shortest: float = 0.2  #: shorter pieces of a railing are left out


@dataclass(frozen=True)
class StairSizes:
    """Ordinary sizes of stairs, metres."""

    waist: float = 0.1  #: a step's body reaches this far below the step before it
    handrail: float = 0.9  #: height of the rail above the edges of the steps
    handrail_in: float = 0.075  #: distance of the rail from the side of the flight
    proud: float = 0.002  #: a railing is moved out of its well, clear of a flight that goes on up


RAILING, STAIRS = RailingSizes(), StairSizes()


def railing(side: Side) -> MeshPart:
    """Return the part ``{room}/railing/{wall}``: posts, two rails, bars."""
    builder = PartBuilder()
    add_railing(builder, side.frame, min(RAILING.height, side.wall.height))
    room = side.room_id
    extras = {"kind": "railing", "room_id": room, "wall_id": side.wall.id}
    return builder.build(f"{room}/railing/{side.wall.id}", extras=extras)


def add_railing(builder: PartBuilder, frame: Frame, top: float = RAILING.height) -> None:
    """Add posts, rails and bars behind a face's line, up to `top` metres."""
    axes, length = frame.axes(0.0), frame.length

    def upright(s: float, width: float, low: float, high: float) -> None:
        half = width / 2
        builder.box(axes, (s - half, low, -width), (s + half, high, 0.0), COLOUR)

    posts = np.linspace(
        RAILING.post / 2, length - RAILING.post / 2, max(2, round(length / RAILING.bay) + 1)
    )
    for s in posts:
        upright(float(s), RAILING.post, 0.0, top - RAILING.rail)
    for low in (0.08, top - RAILING.rail):
        builder.box(axes, (0.0, low, -RAILING.rail), (length, low + RAILING.rail, 0.0), COLOUR)
    for first, second in itertools.pairwise(posts):
        count = int((second - first) / RAILING.gap)
        for s in np.linspace(first, second, count + 2)[1:-1]:
            upright(float(s), RAILING.bar, 0.08 + RAILING.rail, top - RAILING.rail)


def stair_parts(house: House, stairs: Iterable[Stairs]) -> list[MeshPart]:
    """Return the steps of flights and the sides of their wells; y is 0 on their level's floors."""
    parts = []
    colours = dict(house.stair_colours)
    for flight in stairs:
        rise = house.rise_of(flight)
        parts.append(_steps(flight, rise, colours.get(flight.id, WOOD)))
        room = flight.room_ids[0]
        ceiling = None if room is None else house.room(room).height
        if house.level_above(flight.level) is not None and ceiling is not None and ceiling < rise:
            parts.append(_lining(flight, ceiling, rise))
    return parts


def step_areas(stairs: Stairs, rise: float) -> Iterator[tuple[Polygon, float, float]]:
    """Yield the plan area (x, z), lowest and highest height of each step, starting at the foot."""
    start, end = np.array(stairs.start), np.array(stairs.end)
    up = (end - start) / stairs.length
    side = np.array([up[1], -up[0]]) * stairs.width / 2
    count = step_count(rise)
    for k in range(count):
        near, far = (start + (end - start) * share / count for share in (k, k + 1))
        area = Polygon([near + side, far + side, far - side, near - side])
        yield area, max(rise * k / count - STAIRS.waist, 0.0), rise * (k + 1) / count


def _axes(stairs: Stairs) -> np.ndarray:
    """Return a flight's (4, 3) box frame: axes ahead, up, sideways; origin mid-foot."""
    (x, z), (dx, dz) = stairs.start, np.subtract(stairs.end, stairs.start) / stairs.length
    return np.array([[dx, 0.0, dz], [0.0, 1.0, 0.0], [-dz, 0.0, dx], [x, 0.0, z]])


def _steps(stairs: Stairs, rise: float, colour: Colour) -> MeshPart:
    """Return the part ``{room}/stairs/{id}``: a box each step, the last as high as the rise."""
    builder, axes = PartBuilder(), _axes(stairs)
    half, deep = stairs.width / 2, stairs.length / step_count(rise)
    for k, (_, low, high) in enumerate(step_areas(stairs, rise)):
        builder.box(axes, (k * deep, low, -half), ((k + 1) * deep, high, half), colour)
    room, leads_to = stairs.room_ids
    extras = {"kind": "stairs", "category": "stairs", "stairs_id": stairs.id}
    if room is not None:
        extras["room_id"] = room
    if leads_to is not None:
        extras["leads_to"] = leads_to
    return builder.build(f"{room or 'structure'}/stairs/{stairs.id}", extras=extras)


def handrails(house: House, storey: House, stairs: Iterable[Stairs]) -> list[MeshPart]:
    """Return the parts ``{room}/handrail/{id}`` on sides of flights without a wall along them.

    `storey` has the rooms of the flights' level alone.
    """
    free = unary_union([room_polygon(room).buffer(-RAILING.beside_wall) for room in storey.rooms])
    parts = []
    for flight in stairs:
        builder = PartBuilder()
        for side in _edges(flight)[1:3]:
            if _line(side).intersection(free).length >= 0.5 * side.length:
                _add_handrail(builder, flight, house.rise_of(flight), side)
        room = flight.room_ids[0]
        if builder and room is not None:
            extras = {"kind": "railing", "room_id": room, "stairs_id": flight.id}
            parts.append(builder.build(f"{room}/handrail/{flight.id}", extras=extras))
    return parts


def _add_handrail(builder: PartBuilder, stairs: Stairs, rise: float, side: Frame) -> None:
    """Add posts at both ends, two bars a step, and the rail above the steps' edges."""
    count, length = step_count(rise), stairs.length
    deep, riser = length / count, rise / count
    axes = _axes(stairs)
    axes[3, [0, 2]] += side.normal * (stairs.width / 2)
    inward = float(np.sign(axes[2, [0, 2]] @ -side.normal))  # from the side's edge over the steps

    def across(size: float) -> tuple[float, float]:
        ends = (inward * (STAIRS.handrail_in - size / 2), inward * (STAIRS.handrail_in + size / 2))
        return min(ends), max(ends)

    def bar(s: float, size: float) -> None:
        (near, far), half = across(size), size / 2
        low = (min(int(s / deep), count - 1) + 1) * riser
        top = riser + s * rise / length + STAIRS.handrail
        builder.box(axes, (s - half, low, near), (s + half, top, far), COLOUR)

    ends = (0.5 * deep, length - 0.5 * deep)
    for s in ends:
        bar(s, RAILING.post)
    for k in range(2 * count):
        if ends[0] + RAILING.post < (s := (k + 0.5) * deep / 2) < ends[1] - RAILING.post:
            bar(s, RAILING.bar)
    slope = np.array([length, rise]) / float(np.hypot(length, rise))
    tilted = axes.copy()
    tilted[0] = slope[0] * axes[0] + slope[1] * axes[1]
    tilted[1] = slope[0] * axes[1] - slope[1] * axes[0]
    tilted[3] = axes[3] + [0.0, riser + STAIRS.handrail, 0.0]
    near, far = across(RAILING.rail)
    low, high = (s / slope[0] for s in (ends[0] - RAILING.post / 2, ends[1] + RAILING.post / 2))
    builder.box(tilted, (low, -RAILING.rail, near), (high, 0.0, far), COLOUR)


def _lining(stairs: Stairs, low: float, high: float) -> MeshPart:
    """Return the part ``structure/well/{id}``: the sides of the well between two storeys."""
    builder = PartBuilder()
    for frame in _edges(stairs):
        length = frame.length
        corners = np.array([[0, low], [length, low], [length, high], [0, high]])
        inward = Frame(frame.plan(length), -frame.right, -frame.normal, length)
        builder.quad(inward.moved(LIFT).world(corners), REVEAL_COLOUR)
    extras = {"kind": "structure", "stairs_id": stairs.id}
    return builder.build(f"structure/well/{stairs.id}", extras=extras)


def _edges(stairs: Stairs) -> list[Frame]:
    """Return the faces of a flight's strip seen from outside: foot, two sides, head."""
    ring = np.asarray(flight_area(stairs).exterior.coords)
    middle = ring[:4].mean(axis=0)
    frames = []
    for a, b in ((3, 4), (0, 1), (2, 3), (1, 2)):
        along = ring[b] - ring[a]
        normal = np.array([along[1], -along[0]]) / float(np.linalg.norm(along))
        normal *= np.sign((ring[a] + ring[b] - 2 * middle) @ normal)
        frames.append(frame_between(ring[a], ring[b], normal))
    return frames


def well_railings(
    storey: House, arriving: Sequence[Stairs], leaving: Sequence[Stairs]
) -> list[MeshPart]:
    """Return the parts ``{room}/railing/{id}`` around the wells in the floors of a level's rooms.

    There is no railing at the head of an `arriving` flight (one that comes up to the level), along
    walls, or where a `leaving` flight goes on up.
    """
    if not arriving:
        return []
    ways = [_edges(flight)[3] for flight in arriving] + [_edges(flight)[0] for flight in leaving]
    gaps = unary_union([_line(frame).buffer(RAILING.beside_wall) for frame in ways])
    wells = unary_union([flight_area(flight).buffer(-0.01) for flight in arriving])
    shut = unary_union([gaps, wells])
    parts = []
    for flight in arriving:
        builder, owner = PartBuilder(), flight.room_ids[1]
        for room in storey.rooms:
            inside = room_polygon(room).buffer(-RAILING.beside_wall).difference(shut)
            for frame in _edges(flight)[:3]:
                for piece in _pieces(frame, inside):
                    add_railing(builder, piece.moved(STAIRS.proud))
                    owner = owner or room.id
        if builder:
            extras = {"kind": "railing", "room_id": owner, "stairs_id": flight.id}
            parts.append(builder.build(f"{owner}/railing/{flight.id}", extras=extras))
    return parts


def _line(frame: Frame) -> LineString:
    """Return the plan line of a face."""
    return LineString(frame.plan(np.array([0.0, frame.length])))


def _pieces(frame: Frame, inside: BaseGeometry) -> list[Frame]:
    """Return the pieces of a face's line that lie inside an area."""
    covered = _line(frame).intersection(inside)
    pieces = []
    for line in getattr(covered, "geoms", [covered]):
        if line.length < RAILING.shortest:
            continue
        s = np.sort((np.asarray(line.coords) - frame.left) @ frame.right)
        pieces.append(Frame(frame.plan(s[0]), frame.right, frame.normal, float(s[-1] - s[0])))
    return pieces
