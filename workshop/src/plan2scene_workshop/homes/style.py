"""The style model: it draws the material of every surface of a home.

Its correlations between surfaces are what propagation can learn. The tables below are the whole
model (workshop/README.md).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from plan2scene.house import SURFACES, House, Room, SurfaceKey
from plan2scene.materials import Material, palettes, random_material
from plan2scene.seeds import derive_seed, generator

#: Floor of the home's main rooms, one material for all of them.
MAIN_FLOOR = {"wood": 0.72, "tile": 0.16, "carpet": 0.12}
#: Floor by room type. "main": the home's main floor; "bedroom": the home's carpet (or wood) for
#: bedrooms; "wet": the home's tile for wet rooms; "neighbour": that of the room behind the first
#: door; a substance: a material of its own.
FLOOR: Mapping[str, Mapping[str, float]] = {
    "Reception": {"main": 1.0},
    "Corridor": {"main": 0.85, "wet": 0.08, "tile": 0.07},
    "Entrance": {"main": 0.6, "wet": 0.15, "tile": 0.25},
    "Bedroom": {"main": 0.58, "bedroom": 0.37, "wood": 0.05},
    "Kitchen": {"main": 0.42, "wet": 0.25, "tile": 0.33},
    "Bathroom": {"wet": 0.7, "tile": 0.25, "main": 0.05},
    "Closet": {"neighbour": 0.92, "carpet": 0.08},
    "Staircase": {"main": 0.5, "bedroom": 0.3, "carpet": 0.1, "tile": 0.1},
    "Unknown": {"main": 0.6, "tile": 0.2, "carpet": 0.2},
    "Balcony": {"tile": 0.6, "wood": 0.3, "plaster": 0.1},
    "Terrace": {"tile": 0.6, "wood": 0.35, "plaster": 0.05},
    "Outdoor": {"tile": 0.75, "wood": 0.2, "plaster": 0.05},
}
#: Walls by room type. "main": the paint of most rooms; "tint": paint of its own light colour;
#: "accent": a strong colour; "paper": wallpaper; "wet": the home's wall tile for wet rooms.
WALL: Mapping[str, Mapping[str, float]] = {
    "Reception": {"main": 0.74, "tint": 0.12, "accent": 0.05, "paper": 0.06, "plaster": 0.03},
    "Corridor": {"main": 0.88, "tint": 0.06, "paper": 0.06},
    "Entrance": {"main": 0.85, "tint": 0.08, "paper": 0.07},
    "Bedroom": {"main": 0.52, "tint": 0.2, "accent": 0.1, "paper": 0.17, "wood": 0.01},
    "Kitchen": {"main": 0.62, "tint": 0.13, "wet": 0.1, "tile": 0.1, "accent": 0.05},
    "Bathroom": {"wet": 0.55, "tile": 0.2, "main": 0.17, "tint": 0.08},
    "Closet": {"neighbour": 0.55, "main": 0.45},
    "Staircase": {"main": 0.8, "tint": 0.1, "paper": 0.1},
    "Unknown": {"main": 0.75, "tint": 0.15, "paper": 0.1},
    "Balcony": {"facade": 1.0},
    "Terrace": {"facade": 1.0},
    "Outdoor": {"facade": 1.0},
}
#: Ceilings. "main": the home's white; "own": another white; "wall": the colour of the walls.
CEILING: Mapping[str, Mapping[str, float]] = {
    "Bathroom": {"main": 0.88, "own": 0.1, "wood": 0.02},
    "Balcony": {"facade": 0.6, "wood": 0.2, "main": 0.2},
    "Terrace": {"facade": 0.6, "wood": 0.3, "main": 0.1},
    "Outdoor": {"facade": 0.7, "wood": 0.2, "main": 0.1},
    "": {"main": 0.93, "own": 0.04, "wall": 0.02, "wood": 0.01},
}
#: Probability that the wall tile of wet rooms is also their floor tile.
SAME_WET_TILE = 0.3
#: Probability that the home's bedroom floor is carpet (otherwise it is a second wood).
BEDROOM_CARPET = 0.9
#: Probability that a real texture replaces a drawn material, if there are any of its substance.
TEXTURE_SHARE = {"wood": 0.5, "tile": 0.5, "carpet": 0.5, "plaster": 0.12}
#: Probability that a room has one wall of another material (an accent wall).
ACCENT_WALL = {"Reception": 0.16, "Bedroom": 0.22, "Kitchen": 0.08, "Corridor": 0.04}
#: Probability of each material of an accent wall: (substance, kind).
ACCENT_KINDS = {
    ("plaster", "paint"): 0.5,
    ("plaster", "wallpaper"): 0.3,
    ("tile", "brick"): 0.1,
    ("wood", "planks"): 0.1,
}
#: Probability that walls are rough plaster instead of paint.
ROUGH_WALL = 0.25
#: Probability that the main walls of a home have a strong colour.
MAIN_ACCENT = 0.06


@dataclass(frozen=True)
class Style:
    """Tables of the style model by the room's first type; "" is for all types not named."""

    floor: Mapping[str, Mapping[str, float]]
    wall: Mapping[str, Mapping[str, float]]
    ceiling: Mapping[str, Mapping[str, float]]
    main_accent: float  #: probability that the main walls have a strong colour


VARIED = Style(FLOOR, WALL, CEILING, MAIN_ACCENT)
_OUTSIDE = ("Balcony", "Terrace", "Outdoor")
#: Like most homes that are let or sold: the same floor and pale paint in nearly all rooms.
PLAIN = Style(
    {
        **{name: FLOOR[name] for name in _OUTSIDE},
        "Bedroom": {"main": 0.8, "bedroom": 0.2},
        "Kitchen": {"main": 0.65, "wet": 0.15, "tile": 0.2},
        "Bathroom": {"wet": 0.7, "tile": 0.2, "main": 0.1},
        "Closet": {"neighbour": 0.85, "plaster": 0.1, "carpet": 0.05},
        "": {"main": 0.94, "tile": 0.06},
    },
    {
        **{name: WALL[name] for name in _OUTSIDE},
        "Bathroom": {"main": 0.6, "wet": 0.3, "tile": 0.1},
        "": {"main": 0.97, "tint": 0.03},
    },
    {**{name: CEILING[name] for name in _OUTSIDE}, "": {"main": 0.85, "wall": 0.15}},
    0.0,
)


class _Stock:
    """The materials of one home; those that rooms share are made at first use and then kept."""

    def __init__(
        self,
        house_id: str,
        seed: int,
        textures: Sequence[Material],
        size_px: int,
        main_accent: float,
    ) -> None:
        self._size_px = size_px
        self._seed = derive_seed(seed, "style", house_id)
        self._textures = textures
        self._made: dict[str, Material] = {}
        self._recipes: Mapping[str, Callable[[str], Material]] = {
            "main floor": lambda n: self._draw(pick(self.rng(n), MAIN_FLOOR), n),
            "bedroom floor": self._bedroom_floor,
            "wet floor": lambda n: self._draw("tile", n),
            "wet wall": self._wet_wall,
            "main wall": lambda n: self._wall(n, main_accent),
            "main ceiling": self.white,
            "facade": lambda n: self._draw("plaster", n, kind="plaster"),
        }

    def rng(self, *names: object) -> np.random.Generator:
        """Return the generator of a named choice."""
        return generator(self._seed, *names)

    def shared(self, name: str) -> Material:
        """Return a material that rooms of the home share."""
        if name not in self._made:
            self._made[name] = self._recipes[name](name)
        return self._made[name]

    def own(self, what: str, key: SurfaceKey) -> Material:
        """Return a material of one surface: a substance, or tint, accent, paper, own."""
        name = f"{key.room_id}/{key.surface}"
        if what == "own":
            return self.white(name)
        if what in ("tint", "accent"):
            return self._wall(name, 1.0 if what == "accent" else 0.0)
        if what == "paper":
            return self._draw("plaster", name, kind="wallpaper")
        boards = what == "wood" and key.surface != "floor"  # no parquet on walls and ceilings
        return self._draw(what, name, kind="planks" if boards else None)

    def white(self, name: str) -> Material:
        """Return ceiling white: paint, sometimes rough plaster."""
        rng = self.rng(name, "white")
        level, warmth = float(rng.uniform(225, 250)), float(rng.uniform(-2, 9))
        tone = (round(level), round(level - 0.4 * warmth), round(level - warmth))
        kind = "paint" if rng.random() < 0.85 else "plaster"
        return self._random("plaster", name, kind, tone)

    def _draw(self, substance: str, name: str, *, kind: str | None = None) -> Material:
        scan = self._scan(substance, name) if kind in (None, "plaster") else None
        return scan or self._random(substance, name, kind, None)

    def _scan(self, substance: str, name: str) -> Material | None:
        """Return a real texture of the substance with probability `TEXTURE_SHARE`, else None."""
        scans = [t for t in self._textures if t.substance == substance]
        rng = self.rng(name, "texture")
        if scans and rng.random() < TEXTURE_SHARE[substance]:
            return scans[int(rng.integers(0, len(scans)))]
        return None

    def _random(
        self, substance: str, name: str, kind: str | None, tone: tuple[int, int, int] | None
    ) -> Material:
        return random_material(
            substance,
            derive_seed(self._seed, name),
            kind=kind,
            size_px=self._size_px,
            colour_rgb=tone,
        )

    def _wall(self, name: str, strong: float) -> Material:
        """Return paint or rough plaster, of a strong colour with probability `strong`."""
        rng = self.rng(name, "wall")
        kind = "plaster" if rng.random() < ROUGH_WALL else "paint"
        scan = self._scan("plaster", name) if kind == "plaster" else None
        if scan is not None:
            return scan
        palette = palettes.ACCENTS if rng.random() < strong else palettes.PAINTS
        return self._random("plaster", name, kind, _pick_uint8(rng, palette))

    def _bedroom_floor(self, name: str) -> Material:
        carpet = self.rng(name, "substance").random() < BEDROOM_CARPET
        return self._draw("carpet" if carpet else "wood", name)

    def _wet_wall(self, name: str) -> Material:
        if self.rng(name, "same").random() < SAME_WET_TILE:
            return self.shared("wet floor")
        return self._draw("tile", name)


def pick(rng: np.random.Generator, table: Mapping[str, float]) -> str:
    """Return a key of a table of probabilities."""
    shares = np.array(list(table.values()))
    return str(rng.choice(list(table), p=shares / shares.sum()))


def assign_materials(
    house: House,
    seed: int,
    textures: Sequence[Material] = (),
    *,
    size_px: int = 256,
    style: Style = VARIED,
) -> dict[SurfaceKey, Material]:
    """Return the material of every surface of a house; the same seed gives the same materials.

    A room of several types gets the materials of its first type. Real `textures` replace procedural
    ones of their substance with probability `TEXTURE_SHARE`. Procedural tiles have `size_px` pixels
    on each side.
    """
    stock = _Stock(house.id, seed, textures, size_px, style.main_accent)
    chosen: dict[SurfaceKey, Material] = {}
    followers: list[tuple[SurfaceKey, str]] = []
    for room in house.rooms:
        for surface in SURFACES:
            key = SurfaceKey(room.id, surface)
            what = pick(stock.rng(room.id, surface, "what"), _table(style, room, surface))
            if what in ("neighbour", "wall"):
                followers.append((key, what))
            else:
                chosen[key] = _material(stock, key, what)
    for key, what in followers:
        source = SurfaceKey(key.room_id, "wall")
        if what == "neighbour":
            source = SurfaceKey(_behind_door(house, key.room_id), key.surface)
        fallback = f"main {key.surface}"
        chosen[key] = chosen[source] if source in chosen else stock.shared(fallback)
    return {key: chosen[key] for key in house.surface_keys()}


def _table(style: Style, room: Room, surface: str) -> Mapping[str, float]:
    """Return the probabilities of a surface's materials, by the room's first type."""
    tables = {"floor": style.floor, "wall": style.wall, "ceiling": style.ceiling}[surface]
    return tables[room.types[0] if room.types[0] in tables else ""]


def _material(stock: _Stock, key: SurfaceKey, what: str) -> Material:
    """Return the material for a word of the tables."""
    if what in ("main", "bedroom", "wet"):
        return stock.shared(f"{what} {key.surface}")
    if what == "facade":
        return stock.shared("facade")
    return stock.own(what, key)


def _behind_door(house: House, room_id: str) -> str:
    """Return the first room that a door joins to `room_id`, or `room_id` if there is none."""
    for a, b in house.adjacency():
        if room_id in (a, b):
            return b if a == room_id else a
    return room_id


def accent_walls(house: House, seed: int) -> dict[str, Material]:
    """Return the accent walls of a house: wall id to material.

    There is at most one per room, if possible a wall without doors. The true material of the room's
    wall surface remains that of the other walls.
    """
    accents: dict[str, Material] = {}
    for room in house.rooms:
        rng = generator(seed, "accent", house.id, room.id)
        walls = [w for w in house.walls_of(room.id) if w.length >= 1.8]
        if rng.random() >= ACCENT_WALL.get(room.types[0], 0.0) or len(walls) < 3:
            continue
        plain = [w for w in walls if all(o.kind == "window" for o in w.openings)]
        wall = (plain or walls)[int(rng.integers(0, len(plain or walls)))]
        pairs = {f"{substance} {kind}": p for (substance, kind), p in ACCENT_KINDS.items()}
        substance, kind = pick(rng, pairs).split()
        tone = _pick_uint8(rng, palettes.ACCENTS) if kind == "paint" else None
        accents[wall.id] = random_material(
            substance, derive_seed(seed, "accent", house.id, wall.id), kind=kind, colour_rgb=tone
        )
    return accents


def _pick_uint8(rng: np.random.Generator, palette: palettes.Palette) -> tuple[int, int, int]:
    """Return a varied colour of a palette as (r, g, b), 0-255 sRGB."""
    colour = palettes.pick(rng, palette, lightness=2.5, chroma=1.2)
    r, g, b = np.round(colour * 255).astype(int).tolist()
    return r, g, b
