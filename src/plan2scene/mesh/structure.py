"""Floors, ceilings and walls: the surfaces that rooms see, and what stands between and around them.

The faces that rooms see are textured and exact (length x height less openings). The body of a wall
is what a plan draws black: the band behind its face, less all rooms. It has outer faces, a cap
above the ceiling line and the reveals of openings, in plain colours. Skirting boards run along the
foot of a room's walls.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry import LineString, Polygon, box
from shapely.geometry.base import BaseGeometry
from shapely.geometry.polygon import orient
from shapely.ops import unary_union

from plan2scene.colour import RENDER
from plan2scene.house import Level, Room, SurfaceKey, Wall
from plan2scene.mesh.parts import Colour, MeshPart, PartBuilder
from plan2scene.mesh.polygons import polygons_of, triangulate
from plan2scene.plans.wall_sides import (
    LIFT,
    Frame,
    Openings,
    Portal,
    Side,
    arc_offset,
    face_ends,
    frame_between,
    reveal_quads,
)

CAP_COLOUR: Colour = (74, 72, 70)
REVEAL_COLOUR: Colour = (238, 235, 229)
#: Slivers narrower than twice this are left out of bodies, metres.
SLIVER = 1e-4
#: Edges this near to a room or another body get no outer face, metres (rounding only: more
#: would leave cracks between the faces of two bodies).
TOUCH = 5e-6
#: Outer faces of an upper storey begin this far below its floor, metres, and the dark caps of the
#: walls below end this far behind them: the caps do not shine through if depths are coarse.
OVERLAP = 0.02
#: If a wall stands out by up to this, metres, from the walls of the next level, its top is a ledge
#: in the colour of outer faces, not a dark line: traced storeys differ in size.
LEDGE = 0.3
GRID = 1e-6  #: Bodies lie on this grid, metres, so that bands that end on one line do so exactly


@dataclass(frozen=True)
class Above:
    """What is on top of a storey."""

    rise: float  #: metres from its floors to those of the next level
    rooms: BaseGeometry  #: the plan area of that level's rooms
    well: BaseGeometry  #: where stairs go up: open in the ceilings and in the floors above


def wall_face(
    side: Side, room: Room, polygon: BaseGeometry, openings: Openings, key: SurfaceKey
) -> MeshPart | None:
    """Return the face of a wall that a room sees, None when openings leave nothing of it.

    It stands `LIFT` in front of the wall's line. UV in metres: u runs to the right along the
    room's outline, v down from the room's height.
    """
    left, right = face_ends(side.frame, polygon)
    rectangle = box(left, 0.0, right, side.wall.height)
    points, faces = triangulate(rectangle.difference(openings.hole(side)))
    if len(faces) == 0:
        return None
    uv = np.stack([points[:, 0] + arc_offset(room, side.frame), room.height - points[:, 1]], 1)
    builder = PartBuilder()
    builder.mesh(side.frame.moved(LIFT).world(points), faces, uv=uv)
    return builder.build(
        f"{room.id}/wall/{side.wall.id}",
        "surface",
        key,
        {"kind": "wall", "room_id": room.id, "surface": "wall", "wall_id": side.wall.id},
    )


@dataclass(frozen=True)
class Body:
    """The plan area of one wall's body, and of its cap."""

    side: Side
    area: BaseGeometry
    cap: BaseGeometry


def wall_bodies(sides: list[Side], rooms: BaseGeometry) -> list[Body]:
    """Return the body of each wall: its band behind the face, less all rooms and earlier bodies.

    Bands are longer by their depth at both ends, which fills the corners. Walls of one room come
    first. Where rooms touch there is no body, only a cap as wide as the wall.
    """
    first: dict[str, Side] = {}
    for side in sides:
        first.setdefault(side.wall.id, side)
    bodies: list[Body] = []
    taken: BaseGeometry = Polygon()
    caps: BaseGeometry = Polygon()
    for side in sorted(first.values(), key=lambda s: len(s.wall.room_ids)):
        frame, depth = side.frame, side.wall.depth
        ends = np.array([-depth, frame.length + depth])
        band = Polygon([*frame.plan(ends), *frame.plan(ends[::-1], -depth)])
        outside = shapely.difference(band, rooms, grid_size=GRID)
        area = solid_area(shapely.difference(outside, taken, grid_size=GRID))
        inner = ends + [depth / 2, -depth / 2]
        strip = Polygon([*frame.plan(inner, depth / 2), *frame.plan(inner[::-1], -depth / 2)])
        thin = outside.area < 0.6 * frame.length * depth
        cap = unary_union([area, strip]) if thin else area
        cap = solid_area(shapely.difference(cap, caps, grid_size=GRID))
        taken, caps = unary_union([taken, area]), unary_union([caps, cap])
        bodies.append(Body(side, area, cap))
    return bodies


def solid_area(geometry: BaseGeometry) -> BaseGeometry:
    """Return a geometry's polygons without those thinner than twice `SLIVER`."""
    return unary_union([p for p in polygons_of(geometry) if not p.buffer(-SLIVER).is_empty])


def structure_part(
    body: Body,
    bodies: list[Body],
    rooms: BaseGeometry,
    portals: list[Portal],
    above: Above | None = None,
    *,
    low: float = 0.0,
) -> MeshPart | None:
    """Return the part ``structure/wall/{wall}``: outer faces, cap, reveals of the wall's holes.

    Outer faces begin at height `low`. Below rooms of another level the body goes up to their floor.
    """
    wall = body.side.wall
    other_walls = unary_union(
        [b.area for b in bodies if b is not body and b.side.wall.height >= wall.height - 1e-6]
    )
    builder = PartBuilder()
    hidden = unary_union([rooms.buffer(TOUCH), other_walls.buffer(TOUCH)])
    for frame in _free_edges(body.area, hidden):
        _outer_face(builder, frame, (low, wall.height), portals)
    top = wall.height + max(wall.extra_height, 0.0)
    # The cap of the body begins a little below the ceiling line, behind the lifted faces: no crack.
    area, edge = body.area, body.cap.difference(body.area)
    if above is not None and above.rise > wall.height:
        area = _up_to(builder, above, area, wall)
        top = min(top, above.rise - LIFT)
    elif above is not None:
        # The floors above cover what is below them.
        floors = above.rooms.buffer(TOUCH)
        area, edge = area.difference(floors), edge.difference(floors)
    if above is not None:
        ledge = area.intersection(above.rooms.buffer(wall.depth + LEDGE, join_style="mitre"))
        _prism(builder, ledge, wall.height - 10 * LIFT, top, Polygon(), RENDER)
        builder.level(ledge, top, colour=RENDER)
        area = area.difference(ledge)
    no_wall = _full_openings(portals)
    area, edge = area.difference(no_wall), edge.difference(no_wall)
    _prism(builder, area, wall.height - 10 * LIFT, top)
    _prism(builder, edge, wall.height, top)
    for portal in portals:
        if portal.side.wall.id == wall.id and portal.depth >= 1e-4:
            *around, sill = reveal_quads(portal.side.frame, portal.hole, portal.back)
            for quad in (*around, sill) if portal.hole.bottom > 0.02 else around:
                builder.quad(quad, REVEAL_COLOUR)
    if not builder:
        return None
    extras = {"kind": "structure", "wall_id": wall.id}
    return builder.build(f"structure/wall/{wall.id}", extras=extras)


def _full_openings(portals: list[Portal]) -> BaseGeometry:
    """Return the plan area of passages up to the ceiling: no wall is there, and no cap."""
    areas = []
    for portal in portals:
        wall, opening = portal.side.wall, portal.hole.opening
        if opening.kind == "passage" and wall.full(opening):
            frame, ends = portal.side.frame, np.array([portal.hole.left, portal.hole.right])
            front, back = frame.plan(ends, wall.depth), frame.plan(ends[::-1], -2 * wall.depth)
            areas.append(Polygon([*front, *back]))
    return unary_union(areas)


def _up_to(builder: PartBuilder, above: Above, area: BaseGeometry, wall: Wall) -> BaseGeometry:
    """Add the part of a body that goes up to the next level; return the plan area of the rest."""
    under = above.rooms.buffer(wall.depth + TOUCH, join_style="mitre")
    inner = above.rooms.buffer(wall.depth - OVERLAP, join_style="mitre")
    band, high = area.intersection(under), above.rise - OVERLAP / 2
    bare = band.difference(above.rooms)
    cap = bare.intersection(inner)
    _prism(builder, band, wall.height - 10 * LIFT, high, cap, RENDER)
    builder.level(bare.difference(inner), high, colour=RENDER)
    return area.difference(under)


def _edges(geometry: BaseGeometry) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Return (start, end, outward unit normal) of every boundary edge of a polygon geometry."""
    edges = []
    for polygon in polygons_of(geometry):
        polygon = orient(polygon)
        for ring in (polygon.exterior, *polygon.interiors):
            points = np.asarray(ring.coords)
            for start, end in itertools.pairwise(points):
                along = end - start
                length = float(np.linalg.norm(along))
                if length > 1e-6:
                    edges.append((start, end, np.array([along[1], -along[0]]) / length))
    return edges


def _free_edges(area: BaseGeometry, hidden: BaseGeometry) -> list[Frame]:
    """Return the parts of an area's edges outside `hidden`, as faces that look outward.

    Each is longer by `LIFT` at both ends, so that neighbours overlap instead of leaving a crack.
    """
    frames = []
    for start, end, normal in _edges(area):
        free = LineString([start, end]).difference(hidden)
        for line in getattr(free, "geoms", [free]):
            if line.length > 1e-5:
                points = np.asarray(line.coords)
                more = LIFT * (points[-1] - points[0]) / line.length
                frames.append(frame_between(points[0] - more, points[-1] + more, normal))
    return frames


def _outer_face(
    builder: PartBuilder, frame: Frame, heights: tuple[float, float], portals: list[Portal]
) -> None:
    """Add an outer face between two heights, less the portals that go through it."""
    face: BaseGeometry = box(0.0, heights[0], frame.length, heights[1])
    for portal in portals:
        inner = portal.side.frame
        behind = float((inner.left - frame.left) @ inner.normal)
        if abs(frame.normal @ inner.normal) < 0.99 or not -0.01 < behind < portal.depth + 0.01:
            continue
        s = np.sort((portal.back - frame.left) @ frame.right)
        face = face.difference(box(s[0], portal.hole.bottom, s[1], portal.hole.top))
    points, faces = triangulate(face)
    builder.mesh(frame.world(points), faces, colour=RENDER)


def _prism(
    builder: PartBuilder,
    area: BaseGeometry,
    low: float,
    high: float,
    top: BaseGeometry | None = None,
    colour: Colour = CAP_COLOUR,
) -> None:
    """Add the sides of an upright prism in a colour, and a cap over `top` (by default `area`)."""
    builder.level(area if top is None else top, high, colour=CAP_COLOUR)
    if high - low < 1e-6:
        return
    for start, end, normal in _edges(area):
        frame = frame_between(start, end, normal)
        corners = np.array([[0, low], [frame.length, low], [frame.length, high], [0, high]])
        builder.quad(frame.world(corners), colour)


def threshold(portal: Portal) -> MeshPart | None:
    """Return the strip of floor in a door or passage, with the owner room's floor texture."""
    if not portal.has_threshold:
        return None
    quad = reveal_quads(portal.side.frame, portal.hole, portal.back)[3]
    builder = PartBuilder()
    builder.quad(quad, REVEAL_COLOUR, uv=quad[:, [0, 2]])
    room = portal.side.room_id
    extras = {"kind": "threshold", "room_id": room, "opening_id": portal.hole.opening.id}
    name = f"{room}/threshold/{portal.hole.opening.id}"
    return builder.build(name, "surface", SurfaceKey(room, "floor"), extras)


def flat_parts(
    room: Room, polygon: BaseGeometry, well: BaseGeometry, above: Above | None
) -> list[MeshPart]:
    """Return a room's floor (facing up, y = 0) and ceiling (facing down, y = height).

    The floor is open where stairs come up (`well`), the ceiling where they go up to `above`. A room
    in the open air has no ceiling. UV in metres: columns along +x, rows along +z.
    """
    parts = []
    for surface, y in (("floor", 0.0), ("ceiling", room.height)):
        if surface == "ceiling" and room.open_air:
            continue
        builder = PartBuilder()
        builder.level(open_plate(polygon, surface, well, above), y, up=surface == "floor")
        if not builder:
            continue
        extras = {"kind": surface, "room_id": room.id, "surface": surface}
        key = SurfaceKey(room.id, surface)
        parts.append(builder.build(f"{room.id}/{surface}", "surface", key, extras))
    return parts


def open_plate(
    polygon: BaseGeometry, surface: str, well: BaseGeometry, above: Above | None
) -> BaseGeometry:
    """Return a room's plan area less the stairs that go through its floor or ceiling."""
    shaft = well
    if surface == "ceiling":
        shaft = Polygon() if above is None else above.well
    return polygon if shaft.is_empty else polygon.difference(shaft)


def soffit(
    level: Level, rooms: BaseGeometry, bodies: list[Body], below: BaseGeometry
) -> list[MeshPart]:
    """Return the part ``structure/soffit/{level}``: the underside where a level juts out.

    `rooms` and `bodies` are the level's, `below` the plan area of the rooms under it.
    """
    reach = max((body.side.wall.depth for body in bodies), default=0.0)
    walls = unary_union([body.area for body in bodies])
    out = unary_union([rooms, walls]).difference(below.buffer(reach + TOUCH, join_style="mitre"))
    builder = PartBuilder()
    builder.level(solid_area(out), -LIFT, up=False, colour=RENDER)
    if not builder:
        return []
    return [builder.build(f"structure/soffit/{level.id}", extras={"kind": "structure"})]


SKIRTING_COLOUR: Colour = (240, 238, 232)


@dataclass(frozen=True)
class SkirtingSizes:
    """Common sizes of joinery, metres."""

    height: float = 0.07
    depth: float = 0.014
    frame: float = 0.012  #: a board ends this far beside a hole: the frame is there
    shortest: float = 0.05  #: shorter pieces are left out


SKIRTING = SkirtingSizes()


#: Rooms of these types have no skirting: they have tiles up to the wall, or are outside.
WITHOUT = {"Bathroom", "Outdoor", "Balcony", "Terrace", "Staircase"}


def skirting(
    room: Room, sides: Iterable[Side], openings: Openings, colour: Colour | None = None
) -> MeshPart | None:
    """Return the part ``{room}/skirting``, boards of an sRGB `colour`; None for rooms without any.

    `sides` are the faces of the room's walls, `openings` the holes of all faces.
    """
    if WITHOUT & set(room.types):
        return None
    builder = PartBuilder()
    for side in sides:
        for left, right in free_stretches(side, openings.hole(side)):
            builder.box(
                side.frame.axes(0.0),
                (left, 0.0, 0.0),
                (right, SKIRTING.height, SKIRTING.depth),
                colour or SKIRTING_COLOUR,
            )
    if not builder:
        return None
    return builder.build(f"{room.id}/skirting", extras={"kind": "skirting", "room_id": room.id})


def free_stretches(side: Side, holes: BaseGeometry) -> list[tuple[float, float]]:
    """Return (left, right) of the stretches of a face's foot without a hole, metres along it."""
    frame = side.frame
    foot: BaseGeometry = LineString(
        [(0.0, SKIRTING.height / 2), (frame.length, SKIRTING.height / 2)]
    )
    wide = [
        box(x0 - SKIRTING.frame, y0, x1 + SKIRTING.frame, y1)
        for x0, y0, x1, y1 in (part.bounds for part in getattr(holes, "geoms", [holes]))
        if x1 > x0
    ]
    for hole in wide:
        foot = foot.difference(hole)
    lines = [line for line in getattr(foot, "geoms", [foot]) if line.length > SKIRTING.shortest]
    return [(line.bounds[0], line.bounds[2]) for line in lines]
