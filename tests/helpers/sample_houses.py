import json
from dataclasses import replace

import numpy as np
import pytest
from places import STOREYS

from plan2scene.house import Door, House, Opening, Room, Wall
from plan2scene.images import png_bytes
from plan2scene.mesh.assembly import assemble
from plan2scene.mesh.texture_files import TileTexture
from plan2scene.plans.formats import read_plan
from plan2scene.plans.scene_writer import write_scene_json


def walls_of(room, openings=None):
    edges = [(p, ring[(k + 1) % len(ring)]) for ring in room.rings for k, p in enumerate(ring)]
    holes = [tuple((openings or {}).get(k, ())) for k in range(len(edges))]
    return tuple(
        Wall(f"{room.id}_w{k}", (room.id,), *edge, room.height, openings=holes[k])
        for k, edge in enumerate(edges)
    )


def with_openings(house, chosen=lambda _: True, **changes):
    """Return a house whose openings, or those that are chosen, have other values."""

    def changed(wall):
        holes = (replace(o, **changes) if chosen(o) else o for o in wall.openings)
        return replace(wall, openings=tuple(holes))

    return replace(house, walls=tuple(map(changed, house.walls)))


def parts_of(house):
    return {part.name: part for part in assemble(house).parts}


def one_room(kind, width, depth, openings=None, name="room"):
    """Return a house of one room, 2.5 m high, with openings by wall index."""
    room = Room(name, (kind,), (((0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth)),), 2.5)
    return House("h", (room,), walls_of(room, openings))


def rooms_in_a_row(**types):
    """Return rooms of 3 x 3 m side by side, each of a type by its id."""
    corners = ((0.0, 0.0), (3.0, 0.0), (3.0, 3.0), (0.0, 3.0))
    return tuple(
        Room(name, (kind,), (tuple((3.0 * k + x, z) for x, z in corners),), 2.5)
        for k, (name, kind) in enumerate(types.items())
    )


def reception_and_bedroom():
    """Return an L-shaped reception with a window and a bedroom behind its door."""
    ring = ((0.0, 0.0), (5.0, 0.0), (5.0, 4.0), (2.0, 4.0), (2.0, 3.0), (0.0, 3.0))
    a = Room("a", ("Reception",), (ring,), 2.6)
    b = Room("b", ("Bedroom",), (((5.0, 0.0), (9.0, 0.0), (9.0, 4.0), (5.0, 4.0)),), 2.6)
    window = Opening("window", "window", 1.0, 2.6, 0.9, 2.2)
    door = Opening("door", "door", 0.8, 1.65, 0.0, 2.05)
    first, shared, *others = walls_of(a, openings={0: [window], 1: [door]})
    walls = (first, replace(shared, room_ids=("a", "b")), *others, *walls_of(b)[:3])
    return House("two", (a, b), walls, (Door("a", "door", "b"),))


@pytest.fixture
def l_house():
    """An L-shaped room with a front door, a window and two holes that overlap."""
    outline = ((0.0, 0.0), (5.0, 0.0), (5.0, 2.0), (2.0, 2.0), (2.0, 4.0), (0.0, 4.0))
    room = Room("hall", ("Entrance", "Reception"), (outline,), 2.5)
    openings = {
        0: [Opening("front", "door", 1.0, 1.9, 0.0, 2.1)],
        1: [Opening("win", "window", 0.4, 1.6, 0.9, 2.1)],
        5: [
            Opening("low", "window", 0.5, 2.0, 0.5, 1.5),
            Opening("high", "window", 1.5, 2.5, 1.0, 2.0),
        ],
    }
    return House("l", (room,), walls_of(room, openings=openings), (Door("hall", "front", None),))


@pytest.fixture
def ring_house():
    """A room around a light well."""
    outline = ((0.0, 0.0), (0.0, 6.0), (6.0, 6.0), (6.0, 0.0))
    well = ((2.0, 2.0), (3.5, 2.0), (3.5, 4.0), (2.0, 4.0))
    room = Room("ring", ("Corridor",), (outline, well), 2.4)
    return House("ring", (room,), walls_of(room))


@pytest.fixture(scope="session")
def storey_house():
    return read_plan(STOREYS, "two")


@pytest.fixture
def shared_house():
    """Two rooms that touch along one wall with a door in it."""
    a = Room("a", ("Bedroom",), (((0.0, 0.0), (3.0, 0.0), (3.0, 4.0), (0.0, 4.0)),), 2.5)
    b = Room("b", ("Bathroom",), (((3.0, 0.0), (6.0, 0.0), (6.0, 4.0), (3.0, 4.0)),), 2.5)
    door = Opening("d", "door", 1.0, 1.8, 0.0, 2.0)
    shared = Wall("ab", ("a", "b"), (3.0, 0.0), (3.0, 4.0), 2.5, openings=(door,))
    others = [w for w in (*walls_of(a), *walls_of(b)) if w.id not in ("a_w1", "b_w3")]
    return House("shared", (a, b), (shared, *others), (Door("a", "d", "b"),))


@pytest.fixture
def gap_house():
    """Two rooms 0.1 m apart; each has its own copy of the door, as Rent3D++ draws it."""
    a = Room("a", ("Bedroom",), (((0.0, 0.0), (3.0, 0.0), (3.0, 4.0), (0.0, 4.0)),), 2.5)
    b = Room("b", ("Bathroom",), (((3.1, 0.0), (6.0, 0.0), (6.0, 4.0), (3.1, 4.0)),), 2.5)
    walls = (
        *walls_of(a, openings={1: [Opening("ha", "door", 1.0, 1.8, 0.0, 2.0)]}),
        *walls_of(b, openings={3: [Opening("hb", "door", 2.2, 3.0, 0.0, 2.0)]}),
    )
    return House("gap", (a, b), walls, (Door("a", "ha", "b"), Door("b", "hb", "a")))


@pytest.fixture
def paint():
    """Return a texture for every surface of a house, one colour each with a bright corner."""

    def make(house, size_m=0.8):
        textures = {}
        for number, key in enumerate(house.surface_keys()):
            image = np.full((16, 16, 3), 60 + 20 * (number % 8), dtype=np.uint8)
            image[:8, :8] = (200, 120 + number % 100, 40)
            textures[key] = TileTexture(png_bytes(image), size_m, number % 2 == 0, "tile", "test")
        return textures

    return make


@pytest.fixture
def textured(gap_house, paint, tmp_path):
    """Return a folder with `house.scene.json` and the textures of a house of two rooms."""
    write_scene_json(gap_house, tmp_path / "house.scene.json")
    (tmp_path / "textures").mkdir()
    entries = {}
    for key, tile in paint(gap_house).items():
        (tmp_path / "textures" / f"{key.filename}.png").write_bytes(tile.png)
        entry = {"size_m": tile.size_m, "observed": tile.observed, "substance": tile.substance}
        entries["/".join(key)] = entry | {"seam_corrected": False, "source": "test"}
    index = {"method": "synth", "surfaces": entries}
    (tmp_path / "textures" / "textures.json").write_text(json.dumps(index))
    return tmp_path
