"""Fills rooms with models and procedural furniture, clutter, rugs and pictures.

It furnishes training photos (:mod:`.snapshots`), and listing photos if there are models; otherwise
:mod:`.furniture` furnishes listing photos.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from plan2scene.house import Room
from plan2scene.plans.geometry import room_polygon
from plan2scene_workshop.rendering import goods, living, pieces
from plan2scene_workshop.rendering.bedding import covered_bed
from plan2scene_workshop.rendering.furniture import (
    LIKE,
    TRIES,
    TYPICAL_AREA,
    Layout,
    add_piece,
    add_radiators,
    draw_count,
    place_along_wall,
    place_free,
)
from plan2scene_workshop.rendering.geometry import Geometry, box, placement, superquadric
from plan2scene_workshop.rendering.inventory import ALONG_WALLS, BUILT_IN, MAKERS, STANDING_FREE
from plan2scene_workshop.rendering.models import ModelShop
from plan2scene_workshop.rendering.palette import Palette, pick
from plan2scene_workshop.rendering.pieces import Piece
from plan2scene_workshop.rendering.shell import WallFace

#: Name of the emitting material of shining lamps.
GLOW = "glow"
#: Probability that a piece is a model if its class also has a procedural maker.
_MODEL_SHARE = 0.75
_TOPS = {"table", "desk", "cabinet", "nightstand", "coffee table"}


@dataclass(frozen=True)
class RoomStyle:
    """How one room is filled; the tuples hold names of finishes."""

    crowd: float  #: factor on the counts of furniture
    clutter: float  #: factor on the counts of small things and of things on walls
    kind: str | None  #: room type to furnish instead of the room's own; None: the room's own
    skins: tuple[str, ...]  #: textures laid over models; empty: models keep their looks
    bedding: tuple[str, ...]  #: finishes of beds
    fabrics: tuple[str, ...]  #: finishes of rugs
    pictures: tuple[str, ...]  #: finishes of pictures
    lit: float  #: share of standing lamps that shine
    tops: tuple[str, ...] = ()  #: finishes of worktops and tables; empty: no bulk, no boards
    bulk: str = ""  #: furniture that fills the room, one of :data:`.inventory.BULK`, or none
    rugs: float = 1.0  #: factor on the count of rugs
    built_in: float | None = None  #: factor on the counts of built-in furniture; None: `crowd`


class Furnisher:
    """Furnishes the rooms of one scene."""

    def __init__(self, shop: ModelShop, palette: Palette, style: RoomStyle) -> None:
        self.shop, self.palette, self.style = shop, palette, style

    def furnish(
        self,
        geometry: Geometry,
        room: Room,
        faces: tuple[WallFace, ...],
        rng: np.random.Generator,
        cameras: Sequence[shapely.Point] = (),
    ) -> None:
        """Add furniture, clutter, rugs and pictures, clear of walls, doorways and cameras.

        `cameras` are positions (x, z) in metres.
        """
        if not faces:
            return
        layout = Layout(room, faces, cameras)
        kind = LIKE.get(room.types[0], room.types[0]) if room.types else "Bedroom"
        kind = self.style.kind or kind
        scale = min((room_polygon(room).area / TYPICAL_AREA) ** 0.8, 2.2)
        self._height = room.height
        if self.style.tops:
            self._fill(geometry, layout, rng, scale)
        for name, mean in ALONG_WALLS.get(kind, ()):
            for _ in range(draw_count(rng, mean * scale * self._factor(name))):
                place_along_wall(geometry, layout, self.draw(rng, name), rng)
        for name, mean in STANDING_FREE.get(kind, ()):
            for _ in range(draw_count(rng, mean * scale * self._factor(name))):
                place_free(geometry, layout, self.draw(rng, name), rng)
        for _ in range(draw_count(rng, self.style.rugs * rng.choice([0.0, 0.6, 1.6]))):
            self._add_rug(geometry, layout, rng)
        for _ in range(draw_count(rng, 3.5 * scale * self.style.clutter)):
            self._hang(geometry, layout, rng, kitchen=kind == "Kitchen")
        self._hang_lamp(geometry, layout, room, rng)
        add_radiators(geometry, layout, rng)

    def _fill(
        self, geometry: Geometry, layout: Layout, rng: np.random.Generator, scale: float
    ) -> None:
        """Add the bulk furniture of the style, and boards on the walls."""
        bulk = self.style.bulk
        count = draw_count(rng, rng.uniform(1.5, 4.0) * scale) if bulk else 0
        for _ in range(count):
            piece = self._bulky(rng, bulk)
            free = {"tables": 1.0, "rows": 1.0, "counters": 0.35, "beds": 0.3}.get(bulk, 0.0)
            if rng.random() < free:
                place_free(geometry, layout, piece, rng)
            else:
                place_along_wall(geometry, layout, piece, rng)
        for _ in range(draw_count(rng, 0.5)):
            self._hang_up(geometry, layout, rng, goods.board(rng, self.palette), 1.0)

    def _bulky(self, rng: np.random.Generator, bulk: str) -> Piece:
        """Return a piece of one of :data:`.inventory.BULK`."""
        top = (str(rng.choice(list(self.style.tops))), pick(rng, self.palette.furniture))
        top = top if rng.random() < 0.75 else pieces.hard(rng, self.palette)
        height = self._height - 0.03
        tall = height if rng.random() < 0.6 else float(rng.uniform(1.2, height))
        if bulk == "beds":
            cover = str(rng.choice(list(self.style.bedding)))
            return covered_bed(rng, self.palette, (cover, pick(rng, self.palette.fabrics)))
        if bulk == "racks":
            return goods.rack(rng, self.palette, tall)
        if bulk == "cupboards":
            return goods.cupboard_wall(rng, self.palette, min(max(tall, 2.15), height))
        if bulk == "counters":
            return goods.counter(rng, self.palette, top)
        if bulk == "tables":
            return goods.long_table(rng, self.palette, top)
        seat = self.shop.piece(rng, "chair", mounts=("floor",)) or pieces.chair(rng, self.palette)
        desk = goods.long_table(rng, self.palette, top) if rng.random() < 0.5 else None
        return goods.seat_rows(rng, desk, seat)

    def _factor(self, name: str) -> float:
        if name in BUILT_IN and self.style.built_in is not None:
            return self.style.built_in
        small = name in ("small", "heap", "toys", "papers", "carton")
        return self.style.clutter if small else self.style.crowd

    def draw(self, rng: np.random.Generator, name: str) -> Piece:
        """Return a piece of a class."""
        if name == "tall unit":
            return self._tall_unit(rng)
        if name == "papers":
            return goods.papers(rng, self.palette)
        if name == "dining set" and self.shop.has("table") and rng.random() < _MODEL_SHARE:
            return self._dining_set(rng)
        kind = {"coffee table": "table"}.get(name, name)
        piece = None
        if name not in MAKERS or rng.random() < _MODEL_SHARE:
            skins = self.style.skins if rng.random() < 0.6 else ()
            if name == "bed" and rng.random() < 0.5:
                skins = self.style.bedding
            piece = self.shop.piece(rng, kind, mounts=("floor",), skins=skins)
        if piece is None:
            makers = MAKERS.get(name, MAKERS["small"])
            return makers[int(rng.integers(len(makers)))](rng, self.palette)
        if name in _TOPS and piece.height < 1.3:
            self._dress(piece, rng)
        if name == "lamp":
            self._light_up(piece, rng)
        return piece

    def _light_up(self, piece: Piece, rng: np.random.Generator) -> None:
        """Put a shining bulb on a lamp."""
        if rng.random() < self.style.lit:
            middle = (0.0, piece.height + 0.05, piece.depth / 2)
            piece.add((GLOW, (1.0, 1.0, 1.0)), superquadric(middle, (0.07, 0.05, 0.07)))
            piece.height += 0.1

    def _dress(self, piece: Piece, rng: np.random.Generator) -> None:
        """Put small models on a flat top."""
        room = [piece.width * 0.8, piece.depth * 0.7]
        kinds = ["small", "small", "small", "lamp", "plant", "tv", "appliance"]
        for _ in range(draw_count(rng, rng.uniform(0, 3.5) * self.style.clutter * room[0])):
            thing = self.shop.piece(rng, str(rng.choice(kinds)), mounts=("table",))
            if thing is None or thing.width > room[0] or thing.depth > room[1]:
                continue
            if thing.height < 0.7 and rng.random() < self.style.lit * 0.3:
                self._light_up(thing, rng)
            x = rng.uniform(-0.5, 0.5) * (room[0] - thing.width)
            z = piece.depth / 2 + rng.uniform(-0.5, 0.5) * (room[1] - thing.depth)
            turn = placement(x, z, rng.normal(0, 0.5), piece.height)
            piece.put(thing, turn @ placement(0, -thing.depth / 2, 0))

    def _tall_unit(self, rng: np.random.Generator) -> Piece:
        """Return a wardrobe, kitchen or shelf wall, mostly up to the ceiling, white or textured."""
        top = self._height - 0.02 if rng.random() < 0.7 else rng.uniform(1.9, 2.3)
        white = tuple(np.full(3, rng.uniform(0.5, 0.85)) + rng.normal(0, 0.01, 3))
        look = pieces.hard(rng, self.palette) if rng.random() < 0.5 else ("paint", white)
        if self.style.skins and rng.random() < 0.3:
            look = (str(rng.choice(list(self.style.skins))), white)
        size = (rng.uniform(0.6, 2.8), rng.uniform(0.35, 0.65), min(top, self._height - 0.02))
        return pieces.cabinet(rng, self.palette, size, look)

    def _dining_set(self, rng: np.random.Generator) -> Piece:
        """Return a table with chairs of one model on two sides."""
        skins = self.style.skins if rng.random() < 0.4 else ()
        table = self.shop.piece(rng, "table", mounts=("floor",), skins=skins)
        state = rng.integers(2**32)
        if table is None:
            return living.dining_set(rng, self.palette)
        if table.height > 0.6:
            self._dress(table, rng)
        whole = Piece(table.width + 1.0, table.depth + 1.0, max(table.height, 1.0))
        whole.put(table, placement(0, 0.5, 0))
        per_side = max(1, int(table.width / 0.6))
        for k in range(per_side):
            x = (k - (per_side - 1) / 2) * table.width / per_side
            for side, angle in ((0.0, 0.0), (1.0, np.pi)):
                seat = self.shop.piece(np.random.default_rng(state), "chair", mounts=("floor",))
                if seat is None or rng.random() < 0.2:
                    continue
                pull = rng.uniform(-0.1, 0.25)
                z = 0.5 - pull if side == 0 else table.depth + 0.5 + pull
                turn = placement(x, z, angle + rng.normal(0, 0.25))
                whole.put(seat, turn @ placement(0, -seat.depth / 2 - 0.12, 0))
        return whole

    def _add_rug(self, geometry: Geometry, layout: Layout, rng: np.random.Generator) -> None:
        """Lay a rug or a carpet on the floor, sometimes nearly as large as the room."""
        x0, z0, x1, z1 = layout.free.bounds
        if rng.random() < 0.3 and self.shop.has("rug"):
            piece = self.shop.piece(rng, "rug", mounts=("floor",))
            if piece is not None and piece.width < x1 - x0 and piece.depth < z1 - z0:
                spot = rng.uniform((x0, z0), (x1, z1))
                add_piece(geometry, piece, placement(spot[0], spot[1], rng.uniform(0, 6.3)))
                return
        for _ in range(TRIES):
            width, depth = rng.uniform(0.5, 1.0, 2) * rng.uniform(0.6, 3.6)
            x, z = rng.uniform((x0, z0), (x1, z1))
            low = (max(x - width / 2, x0 + 0.05), 0.0, max(z - depth / 2, z0 + 0.05))
            high = (min(x + width / 2, x1 - 0.05), rng.uniform(0.004, 0.02), min(z + depth, z1))
            if high[0] - low[0] > 0.4 and high[2] - low[2] > 0.4:
                rug = box(low, high)
                if layout.free.buffer(0.05).covers(shapely.box(low[0], low[2], high[0], high[2])):
                    geometry.add(str(rng.choice(list(self.style.fabrics))), rug)
                    return

    def _hang(
        self, geometry: Geometry, layout: Layout, rng: np.random.Generator, *, kitchen: bool
    ) -> None:
        """Hang a picture, mirror, screen, small thing or cupboard on a free part of a wall."""
        piece, bottom = self._hanging(rng, kitchen=kitchen)
        self._hang_up(geometry, layout, rng, piece, bottom)

    def _hang_up(
        self,
        geometry: Geometry,
        layout: Layout,
        rng: np.random.Generator,
        piece: Piece,
        bottom: float,
    ) -> None:
        """Hang a piece on a free part of a wall, with its lower edge at height `bottom`."""
        for _ in range(TRIES // 2):
            index = int(rng.integers(len(layout.faces)))
            face, half = layout.faces[index], piece.width / 2
            if face.length < piece.width + 0.1:
                continue
            along = rng.uniform(0.05 + half, face.length - 0.05 - half)
            where = (along - half, along + half, bottom, bottom + piece.height)
            if layout.wall_is_free(index, *where):
                layout.on_walls.append((index, *where))
                add_piece(geometry, piece, face.frame(along, bottom, 0.002))
                return

    def _hanging(self, rng: np.random.Generator, *, kitchen: bool) -> tuple[Piece, float]:
        """Return a piece to hang on a wall, and the height of its lower edge."""
        kinds = ["kitchen", "appliance"] if kitchen else ["picture", "small", "mirror", "tv"]
        if rng.random() < (0.6 if kitchen else 0.3):
            piece = self.shop.piece(rng, str(rng.choice(kinds)), mounts=("wall",))
            if piece is not None and piece.height < 1.2:
                return piece, float(1.4 if kitchen else rng.uniform(1.1, 1.7))
        width, height = np.exp(rng.uniform(-1.6, 0.4)), np.exp(rng.uniform(-1.6, 0.2))
        piece, rim = Piece(float(width), float(height), float(height)), rng.uniform(0.0, 0.06)
        look = ("paint", pick(rng, self.palette.furniture))
        half = width / 2
        piece.add(look, box((-half, 0, 0), (half, height, 0.02)))
        name = str(rng.choice(list(self.style.pictures)))
        inside = box((-half + rim, rim, 0.02), (half - rim, height - rim, 0.022))
        piece.add((name, look[1]), inside)
        return piece, float(np.clip(rng.normal(1.5, 0.2) - height / 2, 0.4, 1.9))

    def _hang_lamp(
        self, geometry: Geometry, layout: Layout, room: Room, rng: np.random.Generator
    ) -> None:
        """Hang a lamp model from the ceiling in some rooms."""
        lamp = self.shop.piece(rng, "lamp", mounts=("ceiling",))
        if lamp is None or rng.random() < 0.6 or lamp.height > room.height - 1.5:
            return
        x0, z0, x1, z1 = layout.free.bounds
        x, z = rng.uniform(0.35, 0.65) * np.array([x1 - x0, z1 - z0]) + (x0, z0)
        turn = placement(x, z, rng.uniform(0, 6.3), room.height - lamp.height)
        add_piece(geometry, lamp, turn @ placement(0, -lamp.depth / 2, 0))
