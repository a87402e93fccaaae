"""What fills training rooms from side to side, and what lines them; needs no Mitsuba."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from plan2scene.house import House, Opening, Room, SurfaceKey, Wall
from plan2scene.photos.labels.palette import CEILING, OTHER, WALL
from plan2scene_workshop.rendering import bedding, goods, linings, pieces
from plan2scene_workshop.rendering.decor import draw_decor, listing_decor
from plan2scene_workshop.rendering.furniture import Layout
from plan2scene_workshop.rendering.geometry import Geometry, Solid, merge
from plan2scene_workshop.rendering.palette import draw_palette
from plan2scene_workshop.rendering.pieces import Piece
from plan2scene_workshop.rendering.randomised import random_surface
from plan2scene_workshop.rendering.shell import WallFace, wall_faces
from plan2scene_workshop.rendering.sources import Sources

HEIGHT = 2.5
TOP = ("top0", (0.5, 0.5, 0.5))
_MAKERS = {
    "table": lambda rng, palette: goods.long_table(rng, palette, TOP),
    "counter": lambda rng, palette: goods.counter(rng, palette, TOP),
    "cupboards": lambda rng, palette: goods.cupboard_wall(rng, palette, HEIGHT),
    "rack": lambda rng, palette: goods.rack(rng, palette, HEIGHT),
    "bed": lambda rng, palette: bedding.covered_bed(rng, palette, TOP),
    "board": goods.board,
    "papers": goods.papers,
}


def _one_room() -> tuple[Room, tuple[WallFace, ...]]:
    """Return a room of 4 x 3 metres with a window and a door."""
    ring = ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0))
    holes = {
        0: (Opening("window", "window", 1.0, 2.6, 0.9, 2.2),),
        2: (Opening("door", "door", 1.0, 1.9, 0.0, 2.05),),
    }
    walls = tuple(
        Wall(f"w{k}", ("a",), ring[k], ring[(k + 1) % 4], HEIGHT, openings=holes.get(k, ()))
        for k in range(4)
    )
    room = Room("a", ("Kitchen",), (ring,), HEIGHT)
    return room, wall_faces(House("one", (room,), walls, ()), room)


def _bounds(piece: Piece) -> tuple[np.ndarray, np.ndarray]:
    vertices = merge([solid for _, solid, _ in piece.parts]).vertices
    return vertices.min(0), vertices.max(0)


@pytest.mark.parametrize("name", _MAKERS)
@pytest.mark.parametrize("seed", range(4))
def test_pieces_stand_in_their_footprint(name: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    piece = _MAKERS[name](rng, draw_palette(rng))
    low, high = _bounds(piece)
    # What lies on a top may reach over its edge, handles stand out.
    spare = 0.35 if name in ("table", "counter", "papers") else 0.08
    assert low[1] >= -1e-9 and low[2] > -spare
    assert max(-low[0], high[0]) < piece.width / 2 + spare and high[2] < piece.depth + spare
    if name in ("rack", "cupboards"):
        assert high[1] == pytest.approx(HEIGHT, abs=0.05)
    if name == "bed":
        cover = np.concatenate([s.vertices for look, s, _ in piece.parts if look == TOP[0]])
        assert np.ptp(cover, axis=0)[[0, 2]].min() > 0.85  # over all of it
    if name in ("table", "counter"):
        tops = [s for look, s, _ in piece.parts if look == TOP[0]]
        assert max(s.vertices[:, 1].max() for s in tops) == pytest.approx(piece.height)


def test_a_rack_is_full() -> None:
    """Seen from the front, goods and boards cover a third of it at least."""
    rng = np.random.default_rng(1)
    piece = goods.rack(rng, draw_palette(rng), HEIGHT)
    parts = [
        shapely.box(*s.vertices[:, :2].min(0), *s.vertices[:, :2].max(0))
        for _, s, _ in piece.parts
        if np.ptp(s.vertices[:, 2]) > 0.02
    ]
    assert shapely.unary_union(parts).area > 0.33 * piece.width * HEIGHT


def test_rows_of_seats_are_one_model_beside_one_another() -> None:
    rng = np.random.default_rng(2)
    seat = pieces.chair(rng, draw_palette(rng))
    whole = goods.seat_rows(rng, None, seat)
    count = len(whole.parts) / len(seat.parts)
    assert count == int(count) and count >= 2
    low, high = _bounds(whole)
    assert high[1] == pytest.approx(_bounds(seat)[1][1])
    assert high[0] - low[0] < whole.width + 0.3 and high[2] - low[2] < whole.depth + 0.5


def _lined(seed: int) -> Geometry:
    geometry = Geometry()
    room, faces = _one_room()
    rng = np.random.default_rng(seed)
    linings.line_room(geometry, room, faces, rng, glow="glow", panelling="panelling")
    return geometry


def test_linings_are_of_the_surface_that_they_line() -> None:
    """Over many rooms: beams and slopes are ceiling, boards wall, lamps other; none outside."""
    seen: dict[str, set[int]] = {}
    for seed in range(80):
        for name, group in _lined(seed).joined().items():
            seen.setdefault(name, set()).update(np.unique(group.labels).tolist())
            low, high = group.solid.vertices.min(0), group.solid.vertices.max(0)
            assert (low > (-0.01, -0.01, -0.01)).all() and (
                high < (4.01, HEIGHT + 0.01, 3.01)
            ).all()
    assert seen["a/ceiling"] == {CEILING} and seen["glow"] == {OTHER}
    assert seen["panelling"] == {CEILING, WALL} and seen["paint"] == {CEILING, WALL}


def test_a_slope_faces_the_room_and_meets_the_ceiling() -> None:
    found = [g for seed in range(80) if (g := _lined(seed).joined().get("a/ceiling"))]
    assert found
    for group in found:
        solid: Solid = group.solid
        a, b, c = solid.vertices[:3]
        flat = np.cross(b - a, c - a)
        assert abs(flat @ solid.normals[0]) == pytest.approx(float(np.linalg.norm(flat)))
        assert solid.normals[0] @ (np.array([2.0, 1.0, 1.5]) - a) > 0
        heights = np.sort(solid.vertices[:, 1])
        assert heights[2:] == pytest.approx(HEIGHT, abs=0.01) and heights[0] > 1.0


def test_boards_leave_openings_free() -> None:
    _, faces = _one_room()
    geometry = Geometry()
    linings._panelling(geometry, faces, np.random.default_rng(0), "panelling", (0.5, 0.5, 0.5))
    solid = geometry.joined()["panelling"].solid
    for face in faces:
        for hole in face.openings:
            along = (solid.vertices[:, [0, 2]] - face.at(0, 0)[[0, 2]]) @ face.plane.right
            off = (solid.vertices[:, [0, 2]] - face.at(0, 0)[[0, 2]]) @ face.plane.normal
            inside = (along > hole.left) & (along < hole.right) & (np.abs(off) < 0.05)
            y = solid.vertices[inside, 1]
            assert not ((y > hole.bottom) & (y < hole.top)).any()


def test_rectangles_make_up_their_region() -> None:
    region = shapely.box(0, 0, 4, 2).difference(shapely.box(1, 0.5, 2, 1.5))
    boxes = [shapely.box(*bounds) for bounds in linings._rectangles(region)]
    assert sum(part.area for part in boxes) == pytest.approx(region.area)
    assert shapely.unary_union(boxes).equals(region)
    assert linings._rectangles(shapely.Polygon()) == []


def test_tiles_are_drawn_from_the_seed() -> None:
    made = [
        (
            linings.grid_ceiling(rng).albedo,
            linings.granite(rng),
            linings.panels(rng, None),
            bedding.patchwork(rng),
        )
        for rng in (np.random.default_rng(5), np.random.default_rng(5))
    ]
    for first, again in zip(*made, strict=True):
        assert first.dtype == np.uint8 and first.ndim == 3 and first.std() > 1
        assert np.array_equal(first, again)


def test_listings_rooms_stay_plain() -> None:
    """Nothing of this is in the photos of listings."""
    listing, snapshot = listing_decor(Sources(), 3), draw_decor(Sources(), 3, randomised=False)
    for name in ("top0", "quilt0"):
        assert name not in listing.finishes() and name in snapshot.finishes()
    assert set(listing.style.bedding) <= set(listing.finishes())
    assert listing.style.tops == () and listing.style.bulk == ""


@pytest.mark.parametrize(("bulk", "low"), [("racks", 1.2), ("beds", 0.35)])
def test_rooms_are_filled_with_their_bulk(bulk: str, low: float) -> None:
    room, faces = _one_room()
    decor = draw_decor(Sources(), 1, randomised=False)
    style = replace(decor.style, bulk=bulk, crowd=0.0, clutter=0.0)
    furnisher = replace(decor, style=style).furnisher()
    furnisher._height = HEIGHT
    layout, geometry = Layout(room, faces, ()), Geometry()
    furnisher._fill(geometry, layout, np.random.default_rng(0), 1.0)
    assert len(layout.taken) >= 2  # a piece beside the door's clearance
    top = max(group.solid.vertices[:, 1].max() for group in geometry.joined().values())
    assert low <= top <= HEIGHT


def test_emptied_rooms_keep_what_is_built_in() -> None:
    """Over many rooms hardly a thing is left, but kitchens are; surfaces are the home's own."""
    room, faces = _one_room()
    left = {True: 0, False: 0}
    for seed in range(12):
        for emptied in left:
            decor = draw_decor(Sources(), seed, randomised=False, emptied=emptied)
            geometry = Geometry()
            decor.furnisher().furnish(geometry, room, faces, np.random.default_rng(seed))
            left[emptied] += sum(len(g.solid.faces) for g in geometry.joined().values())
            if emptied:
                assert decor.style.bulk == "" and decor.style.tops == ()
                assert decor.style.crowd < 0.4 and decor.style.rugs < 0.4
    assert 0 < left[True] < 0.35 * left[False]
    key = SurfaceKey("a", "wall")
    paint = random_surface(key, 1)
    for seed in range(12):
        decor = draw_decor(Sources(), seed, randomised=False, emptied=True)
        assert decor.materials({key: paint}) == {key: paint}
