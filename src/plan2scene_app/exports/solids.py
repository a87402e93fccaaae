"""A house as solids of closed convex pieces, each solid with a name and a category.

All exporters that need solids use this module. World axes as in ``docs/conventions.md``: metres,
y up; plan points are (x, z).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import shapely
import trimesh
from shapely.geometry import LineString, Polygon
from shapely.geometry.base import BaseGeometry
from shapely.ops import unary_union

from plan2scene.house import House
from plan2scene.mesh.assembly import Assembly, Storey, assemble
from plan2scene.mesh.joinery import JOINERY, is_glazed, is_hatch
from plan2scene.mesh.parts import MeshPart, numbered
from plan2scene.mesh.polygons import polygons_of, triangulate
from plan2scene.mesh.structure import Body, open_plate
from plan2scene.plans.geometry import room_polygon
from plan2scene.plans.wall_sides import Portal

#: Thickness of floors and ceilings, metres.
SLAB = 0.1
#: Least thickness of a wall, metres; used where two rooms touch.
LEAST_WALL = 0.02
#: Thickness of window panes, metres.
PANE = 0.02
#: Kinds of parts that consist of boxes.
BOXED = frozenset({"object", "stairs", "railing"})
#: Pieces with a smaller plan area are left out, square metres.
_SLIVER = 1e-5
#: Gap between a door leaf and its frame on each side, metres.
_GAP = 0.01


@dataclass(frozen=True)
class Hinge:
    """The upright axis of a door leaf. At angle 0 the door is shut.

    Attributes
    ----------
    x, z : float
        Plan point of the axis, metres.
    opens : int
        +1 when a positive turn about +y opens it, else -1.
    """

    x: float
    z: float
    opens: int


@dataclass(frozen=True)
class Solid:
    """A solid thing in the house.

    Attributes
    ----------
    name : str
        Unique in the house, like the GLB's nodes: ``{room}/floor``, ``wall/{wall}`` ...
    category : str
        ``floor``, ``ceiling``, ``wall``, ``door``, ``window``, ``railing``, or the kind of an
        object of the plan (:data:`plan2scene.mesh.fittings.KINDS`).
    room_ids : tuple of str
        The rooms it belongs to.
    pieces : tuple of trimesh.Trimesh
        Closed convex meshes that face outward; together they fill the solid. Metres, world axes.
    hinge : Hinge or None
        The hinge of a door leaf, None for anything else.
    ajar : bool
        Whether it is a leaf that stands open in the textured house: a body that cannot turn would
        shut its room off.
    """

    name: str
    category: str
    room_ids: tuple[str, ...]
    pieces: tuple[trimesh.Trimesh, ...] = field(compare=False)
    hinge: Hinge | None = None
    ajar: bool = False


def house_solids(house: House, assembly: Assembly | None = None) -> list[Solid]:
    """Return the solids of a house: slabs, walls with their holes, door leaves, panes, objects.

    Doors and passages are holes through the walls with floor in them. A door leaf is shut and fills
    its hole. A pane fills a window; a hatch (a window between two rooms) stays empty. `assembly` is
    that of the house, if the caller already has it.
    """
    assembly = assemble(house) if assembly is None else assembly
    solids: list[Solid] = []
    for storey in assembly.storeys:
        solids.extend(_lifted(solid, storey.level.elevation) for solid in storey_solids(storey))
    names = numbered(solid.name for solid in solids)
    return [replace(solid, name=name) for solid, name in zip(solids, names, strict=True)]


def storey_solids(storey: Storey) -> list[Solid]:
    """Return the solids of one storey, with its floors at height 0; names may repeat."""
    ways = {id(portal): footprint(portal) for portal in storey.portals}
    solids: list[Solid] = []
    for room in storey.house.rooms:
        polygon = room_polygon(room)
        for surface, low in (("floor", -SLAB), ("ceiling", room.height)):
            if surface == "ceiling" and room.open_air:
                continue
            plate = open_plate(polygon, surface, storey.well, storey.above)
            pieces = prisms(plate, low, low + SLAB)
            if pieces:
                solids.append(Solid(f"{room.id}/{surface}", surface, (room.id,), pieces))
    solids.extend(_walls(storey, ways))
    solids.extend(_thresholds(storey, ways))
    rooms = {room.id: room for room in storey.house.rooms}
    indoors = {room.id for room in storey.house.rooms if not room.open_air}
    for portal in storey.portals:
        if not is_hatch(portal, indoors):
            ajar = portal.other is not None and not is_glazed(portal, rooms)
            solids.extend(_fillings(portal, ajar=ajar))
    solids.extend(_boxed(part) for part in storey.parts if part.extras["kind"] in BOXED)
    return solids


def _lifted(solid: Solid, elevation: float) -> Solid:
    """Return a storey's solid moved up to the storey's elevation in the house."""
    if elevation == 0.0:
        return solid
    pieces = tuple(piece.copy() for piece in solid.pieces)
    for piece in pieces:
        piece.apply_translation([0.0, elevation, 0.0])
    return replace(solid, pieces=pieces)


def _boxed(part: MeshPart) -> Solid:
    """Return the solid of a part that `PartBuilder.box` made: every 24 vertices are one box."""
    boxes = part.mesh.vertices.reshape(-1, 24, 3)
    kind = str(part.extras.get("category", part.extras["kind"]))
    rooms = (str(part.extras["room_id"]),) if "room_id" in part.extras else ()
    pieces = tuple(trimesh.convex.convex_hull(corners) for corners in boxes)
    return Solid(part.name, kind, rooms, pieces)


def prisms(area: BaseGeometry, low: float, high: float) -> tuple[trimesh.Trimesh, ...]:
    """Return upright convex prisms that fill a plan area from height `low` to `high`.

    A convex polygon gives one prism, any other polygon a prism for each of its triangles.
    """
    if high - low < 1e-4:
        return ()
    pieces = []
    for polygon in polygons_of(area):
        outline = shapely.simplify(polygon, 1e-6)
        if outline.area < _SLIVER:
            continue
        if not outline.interiors and outline.convex_hull.area - outline.area < _SLIVER:
            pieces.append(_prism(np.asarray(outline.convex_hull.exterior.coords)[:-1], low, high))
            continue
        points, faces = triangulate(outline)
        pieces.extend(
            _prism(points[face], low, high)
            for face in faces
            if Polygon(points[face]).area > _SLIVER
        )
    return tuple(pieces)


def _prism(ring: np.ndarray, low: float, high: float) -> trimesh.Trimesh:
    """Return the prism over a convex ring (n, 2) of plan points."""
    corners = [np.insert(ring, 1, y, axis=1) for y in (low, high)]
    return trimesh.convex.convex_hull(np.concatenate(corners))


def footprint(portal: Portal) -> Polygon:
    """Return the plan area of an opening through its walls, a little deeper than the walls."""
    frame, hole = portal.side.frame, portal.hole
    reach = LEAST_WALL
    near = frame.plan(np.array([hole.left, hole.right]), reach)
    far = portal.back - reach * frame.normal
    return Polygon([near[0], near[1], far[1], far[0]])


def _walls(storey: Storey, ways: dict[int, Polygon]) -> list[Solid]:
    """Return a solid for each wall, cut by all openings that go through it."""
    solids = []
    taken: BaseGeometry = Polygon()
    for body in storey.bodies:
        wall = body.side.wall
        area = shapely.difference(wall_area(body), taken)
        taken = unary_union([taken, area])
        through = [p for p in storey.portals if ways[id(p)].intersects(area)]
        holes = unary_union([ways[id(p)] for p in through])
        pieces = list(prisms(area.difference(holes), 0.0, wall.height))
        for portal in through:
            inside = area.intersection(ways[id(portal)])
            pieces.extend(prisms(inside, 0.0, portal.hole.bottom))
            pieces.extend(prisms(inside, portal.hole.top, wall.height))
        if pieces:
            solids.append(Solid(f"wall/{wall.id}", "wall", wall.room_ids, tuple(pieces)))
    return solids


def wall_area(body: Body) -> BaseGeometry:
    """Return a wall's plan area, which contains at least a thin strip along the wall's line."""
    frame = body.side.frame
    line = LineString(frame.plan(np.array([0.0, frame.length])))
    return unary_union([body.area, line.buffer(LEAST_WALL / 2, cap_style="flat")])


def _thresholds(storey: Storey, ways: dict[int, Polygon]) -> list[Solid]:
    """Return the floor inside doors and passages."""
    rooms = unary_union([room_polygon(room) for room in storey.house.rooms])
    solids = []
    for portal in storey.portals:
        opening, room = portal.hole.opening, portal.side.room_id
        if opening.kind == "window" or portal.hole.bottom > 0.02:
            continue
        pieces = prisms(ways[id(portal)].difference(rooms), -SLAB, 0.0)
        if pieces:
            both = (room,) if portal.other is None else (room, portal.other)
            solids.append(Solid(f"{room}/threshold/{opening.id}", "floor", both, pieces))
    return solids


def _fillings(portal: Portal, *, ajar: bool) -> list[Solid]:
    """Return what fills an opening: a pane, one or two door leaves, or nothing in a passage.

    `ajar` is that of the leaves.
    """
    hole, room = portal.hole, portal.side.room_id
    both = (room,) if portal.other is None else (room, portal.other)
    name = f"{room}/{hole.opening.kind}/{hole.opening.id}"
    width = hole.right - hole.left
    if hole.opening.kind == "passage" or width < 0.15 or hole.top - hole.bottom < 0.15:
        return []
    if hole.opening.kind == "window":
        pane = _slab(portal, 0.0, width, PANE, hole.bottom, hole.top)
        return [Solid(name, "window", both, (pane,))]
    jamb = min(JOINERY.frame, 0.12 * width)
    ends = [(jamb, width - jamb)]
    if width > JOINERY.two_leaves:
        ends = [(jamb, width / 2), (width - jamb, width / 2)]
    leaves = []
    for number, (hinge, edge) in enumerate(ends):
        low, high = sorted((hinge, edge))
        body = _slab(
            portal, low + _GAP, high - _GAP, JOINERY.leaf, hole.bottom + _GAP, hole.top - jamb
        )
        x, z = portal.side.frame.plan(hole.left + hinge, -portal.depth / 2)
        axis = Hinge(float(x), float(z), 1 if edge < hinge else -1)
        leaves.append(Solid(f"{name}/leaf{number}", "door", both, (body,), axis, ajar))
    return leaves


def _slab(
    portal: Portal, left: float, right: float, thick: float, low: float, high: float
) -> trimesh.Trimesh:
    """Return a flat upright box in the middle of an opening's depth."""
    return _prism(middle_strip(portal, left, right, thick), low, high)


def middle_strip(portal: Portal, left: float, right: float, thick: float) -> np.ndarray:
    """Return the (4, 2) plan corners of a strip in the middle of an opening's depth.

    `left` and `right` are metres from the opening's left edge, `thick` metres across.
    """
    frame, start = portal.side.frame, portal.hole.left
    along = np.array([start + left, start + right])
    front, rear = (frame.plan(along, -portal.depth / 2 + side * thick / 2) for side in (1, -1))
    return np.concatenate([front, rear[::-1]])
