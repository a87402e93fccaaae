"""What fills training rooms from side to side, and what lines them; needs no Mitsuba."""

from __future__ import annotations

import numpy as np
import pytest

from plan2scene.house import House, Opening, Room, Wall
from plan2scene.photos.labels.palette import CEILING, OTHER, WALL
from plan2scene_workshop.rendering import bedding, goods, linings
from plan2scene_workshop.rendering.geometry import Geometry, merge
from plan2scene_workshop.rendering.palette import draw_palette
from plan2scene_workshop.rendering.pieces import Piece
from plan2scene_workshop.rendering.shell import WallFace, wall_faces

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
