"""Furnishes a room: draws and places its furniture, rugs and pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import shapely

from plan2scene.house import Room
from plan2scene.plans.geometry import room_polygon
from plan2scene_workshop.rendering import living, pieces, randomised, service
from plan2scene_workshop.rendering.geometry import Array, Geometry, box, placement
from plan2scene_workshop.rendering.palette import FABRICS, PICTURES, RUGS, Palette, pick
from plan2scene_workshop.rendering.pieces import Maker, Piece
from plan2scene_workshop.rendering.shell import WallFace

#: For each room type: makers of pieces along walls and of free-standing ones, with mean counts.
ALONG_WALLS: Mapping[str, Sequence[tuple[Maker, float]]] = {
    "Reception": (
        (living.sofa, 1.3),
        (living.television, 0.8),
        (living.bookshelf, 0.9),
        (living.dresser, 0.6),
        (service.plant, 0.9),
        (living.floor_lamp, 0.6),
        (living.desk, 0.25),
        (living.armchair, 0.5),
        (service.carton, 0.2),
    ),
    "Bedroom": (
        (living.bed, 1.15),
        (living.wardrobe, 0.9),
        (living.night_table, 1.2),
        (living.dresser, 0.6),
        (living.desk, 0.35),
        (living.bookshelf, 0.3),
        (service.plant, 0.4),
        (living.armchair, 0.2),
        (service.carton, 0.2),
    ),
    "Kitchen": (
        (service.kitchen_run, 1.7),
        (service.fridge, 0.9),
        (living.bookshelf, 0.15),
        (service.plant, 0.3),
        (pieces.chair, 0.4),
        (service.carton, 0.15),
    ),
    "Bathroom": (
        (service.basin, 1.0),
        (service.toilet, 0.9),
        (service.bathtub, 0.7),
        (service.washer, 0.4),
        (living.dresser, 0.2),
    ),
    "Corridor": (
        (service.coat_rack, 0.4),
        (living.dresser, 0.4),
        (service.plant, 0.3),
        (living.bookshelf, 0.2),
    ),
    "Closet": ((living.wardrobe, 0.8), (living.bookshelf, 0.8), (service.carton, 1.0)),
    "Outdoor": ((service.plant, 1.5), (pieces.chair, 0.8)),
}
STANDING_FREE: Mapping[str, Sequence[tuple[Maker, float]]] = {
    "Reception": (
        (living.coffee_table, 0.9),
        (living.dining_set, 0.6),
        (living.armchair, 0.5),
        (living.ottoman, 0.4),
    ),
    "Bedroom": ((living.ottoman, 0.35), (pieces.chair, 0.2)),
    "Kitchen": ((living.dining_set, 0.5),),
    "Outdoor": ((living.dining_set, 0.4),),
}
LIKE = {
    "Unknown": "Bedroom",
    "Entrance": "Corridor",
    "Staircase": "Corridor",
    "Terrace": "Outdoor",
    "Balcony": "Outdoor",
}
#: Floor area in square metres of a room for which the counts above hold.
TYPICAL_AREA = 14.0
TRIES = 40
#: Least distance of a camera from pieces up to 1.1 m high, and from higher ones, metres.
CAMERA_CLEARANCE = (0.5, 1.0)
DOOR_CLEARANCE = 0.85


class Layout:
    """The occupied space of a room: floor footprints, and rectangles on the wall faces."""

    def __init__(
        self, room: Room, faces: tuple[WallFace, ...], cameras: Sequence[shapely.Point]
    ) -> None:
        self.faces = faces
        inset = max((face.inset for face in faces), default=0.05)
        self.free = room_polygon(room).buffer(-inset - 0.012, join_style="mitre")
        self.cameras = cameras
        self.taken: list[shapely.Geometry] = []
        self.on_walls: list[tuple[int, float, float, float, float]] = []
        for index, face in enumerate(faces):
            for hole in face.openings:
                self.on_walls.append((index, hole.left, hole.right, hole.bottom, hole.top))
                if hole.bottom < 0.3:
                    self.taken.append(_rectangle(face, hole.left, hole.right, 0.0, DOOR_CLEARANCE))

    def fits(self, footprint: shapely.Polygon, height: float) -> bool:
        """Return whether a footprint is in the room and clear of all other things and cameras."""
        clearance = CAMERA_CLEARANCE[1] if height > 1.1 else CAMERA_CLEARANCE[0]
        return (
            self.free.contains(footprint)
            and not any(footprint.intersects(other) for other in self.taken)
            and all(footprint.distance(camera) > clearance for camera in self.cameras)
        )

    def wall_is_free(self, index: int, low: float, high: float, bottom: float, top: float) -> bool:
        """Return whether a rectangle of a face has nothing on it."""
        face = self.faces[index]
        if low < 0.02 or high > face.length - 0.02 or top > face.height - 0.05:
            return False
        return not any(
            i == index and low < b and high > a and bottom < t and top > lo
            for i, a, b, lo, t in self.on_walls
        )


def furnish_room(
    geometry: Geometry,
    room: Room,
    faces: tuple[WallFace, ...],
    palette: Palette,
    rng: np.random.Generator,
    cameras: Sequence[shapely.Point],
    *,
    random_room: bool = False,
) -> None:
    """Add furniture, rugs and pictures, clear of walls, doorways and cameras.

    `cameras` are positions (x, z) in metres. A `random_room` also gets the things of
    :mod:`.randomised`.
    """
    if not faces:
        return
    layout = Layout(room, faces, cameras)
    kind = LIKE.get(room.types[0], room.types[0]) if room.types else "Bedroom"
    scale = min((room_polygon(room).area / TYPICAL_AREA) ** 0.7, 2.0)
    crowd = scale * float(rng.uniform(0.5, 1.3))
    built_in = randomised.ALONG_WALLS if random_room else ()
    strewn = randomised.STANDING_FREE if random_room else ()
    for maker, mean in (*built_in, *ALONG_WALLS.get(kind, ())):
        for _ in range(draw_count(rng, mean * max(crowd, 0.7))):
            place_along_wall(geometry, layout, maker(rng, palette), rng)
    for maker, mean in (*STANDING_FREE.get(kind, ()), *strewn):
        for _ in range(draw_count(rng, mean * crowd)):
            place_free(geometry, layout, maker(rng, palette), rng)
    if kind in ("Reception", "Bedroom", "Corridor") and rng.random() < 0.45:
        _add_rug(geometry, layout, rng)
    for _ in range(draw_count(rng, 2.2 * scale)):
        _hang(geometry, layout, palette, rng)
    add_radiators(geometry, layout, rng)


def draw_count(rng: np.random.Generator, mean: float) -> int:
    """Return a random integer next to `mean` whose expected value is `mean`."""
    return int(mean + rng.random())


def _rectangle(face: WallFace, low: float, high: float, near: float, far: float) -> shapely.Polygon:
    """Return a rectangle of the floor by its distances along and from a face."""
    corners = [(low, near), (high, near), (high, far), (low, far)]
    return shapely.Polygon([face.at(a, 0.0, out)[[0, 2]] for a, out in corners])


def add_piece(geometry: Geometry, piece: Piece, matrix: Array) -> None:
    """Add the parts of a piece under a transform."""
    for material, solid, colour in piece.parts:
        geometry.add(material, solid.moved(matrix), colour=colour)


def place_along_wall(
    geometry: Geometry, layout: Layout, piece: Piece, rng: np.random.Generator
) -> bool:
    """Place a piece with its back to a wall; return whether a place was found."""
    lengths = np.array([max(face.length, 0.0) for face in layout.faces])
    for _ in range(TRIES):
        index = int(rng.choice(len(lengths), p=lengths / lengths.sum()))
        face, half = layout.faces[index], piece.width / 2
        spare = face.length - piece.width - 0.04
        if spare <= 0:
            continue
        share = rng.random() if rng.random() < 0.6 else float(rng.integers(2))
        along = 0.02 + half + spare * share
        out = 0.015 + abs(rng.normal(0, 0.02))
        footprint = _rectangle(face, along - half, along + half, out, out + piece.depth)
        on_wall = (along - half, along + half, 0.0, piece.height)
        if layout.fits(footprint, piece.height) and layout.wall_is_free(index, *on_wall):
            layout.taken.append(footprint)
            layout.on_walls.append((index, *on_wall))
            add_piece(geometry, piece, face.frame(along, 0.0, out))
            return True
    return False


def place_free(geometry: Geometry, layout: Layout, piece: Piece, rng: np.random.Generator) -> bool:
    """Place a piece in the room, nearly parallel to the walls; return whether it fits."""
    x0, z0, x1, z1 = layout.free.bounds
    face = layout.faces[0]
    square = float(np.arctan2(*face.plane.normal))
    half = piece.width / 2
    corners = np.array([[-half, 0], [half, 0], [half, piece.depth], [-half, piece.depth]])
    for _ in range(TRIES):
        angle = square + np.pi / 2 * rng.integers(4) + rng.normal(0, 0.08)
        matrix = placement(rng.uniform(x0, x1), rng.uniform(z0, z1), angle)
        flat = matrix[np.ix_([0, 2], [0, 2])]
        footprint = shapely.Polygon(corners @ flat.T + matrix[[0, 2], 3])
        if layout.fits(footprint.buffer(0.12), piece.height):
            layout.taken.append(footprint)
            add_piece(geometry, piece, matrix)
            return True
    return False


def _add_rug(geometry: Geometry, layout: Layout, rng: np.random.Generator) -> None:
    """Add a flat rug; it may lie under furniture."""
    x0, z0, x1, z1 = layout.free.bounds
    name = str(rng.choice([*RUGS, *FABRICS]))
    for _ in range(TRIES):
        size = rng.uniform((0.7, 0.5), (min(3.0, x1 - x0), min(2.2, z1 - z0)))
        x, z = rng.uniform((x0, z0), (x1, z1))
        rug = shapely.box(x - size[0] / 2, z - size[1] / 2, x + size[0] / 2, z + size[1] / 2)
        if layout.free.contains(rug.buffer(0.05)):
            a, b, c, d = rug.bounds
            geometry.add(name, box((a, 0.0, b), (c, float(rng.uniform(0.006, 0.016)), d)))
            return


def _hang(geometry: Geometry, layout: Layout, palette: Palette, rng: np.random.Generator) -> None:
    """Hang a framed picture, a mirror, or a small shelf on a free piece of wall."""
    width, height = rng.uniform(0.25, 1.0), rng.uniform(0.25, 0.8)
    for _ in range(TRIES):
        index = int(rng.integers(len(layout.faces)))
        face = layout.faces[index]
        if face.length < width + 0.3:
            continue
        along = rng.uniform(0.15 + width / 2, face.length - 0.15 - width / 2)
        low = rng.uniform(1.45, 1.7) - height / 2
        rectangle = (along - width / 2, along + width / 2, low, low + height)
        if not layout.wall_is_free(index, *rectangle):
            continue
        layout.on_walls.append((index, *rectangle))
        frame = face.frame(along, low)
        look = ("paint", pick(rng, palette.furniture))
        kind = rng.random()
        if kind < 0.15:
            board = box((-width / 2, 0, 0), (width / 2, 0.03, 0.2))
            geometry.add(look[0], board.moved(frame), colour=look[1])
            shelf = Piece(width, 0.2, 0.03)
            pieces.scatter(shelf, rng, palette, 0.03, int(rng.integers(2, 5)))
            add_piece(geometry, shelf, frame)
            return
        rim = rng.uniform(0.012, 0.05)
        border = box((-width / 2, 0, 0), (width / 2, height, 0.022))
        geometry.add(look[0], border.moved(frame), colour=look[1])
        inside = box((-width / 2 + rim, rim, 0.022), (width / 2 - rim, height - rim, 0.024))
        name = "mirror" if kind < 0.2 else str(rng.choice(PICTURES))
        geometry.add(name, inside.moved(frame))
        return


def add_radiators(geometry: Geometry, layout: Layout, rng: np.random.Generator) -> None:
    """Add a radiator under some windows where nothing else stands."""
    for index, face in enumerate(layout.faces):
        for hole in face.openings:
            if hole.opening.kind != "window" or hole.bottom < 0.7 or rng.random() < 0.4:
                continue
            low, high = hole.left + 0.15, hole.right - 0.15
            if high - low < 0.4 or not layout.wall_is_free(index, low, high, 0.12, 0.68):
                continue
            ribs = round((high - low) / 0.06)
            for k in range(ribs):
                x = low + (high - low) * k / ribs
                rib = box((x, 0.12, 0.03), (x + 0.045, 0.68, 0.11))
                geometry.add("gloss", rib.moved(face.frame(0)), colour=(0.8, 0.8, 0.78))
