from __future__ import annotations

import numpy as np
import pytest

from plan2scene.photos.labels.palette import OTHER
from plan2scene.plans.wall_sides import FaceOpening
from plan2scene.seeds import generator
from plan2scene_workshop.homes.floorplans import generate_house
from plan2scene_workshop.rendering.coverings import COVERINGS, add_covering
from plan2scene_workshop.rendering.geometry import Geometry, JoinedGroup
from plan2scene_workshop.rendering.palette import draw_palette
from plan2scene_workshop.rendering.shell import OUTER_REVEAL, WallFace, wall_faces


def _windows() -> list[tuple[WallFace, FaceOpening]]:
    house = generate_house("h", 3)
    return [
        (face, hole)
        for room in house.rooms
        for face in wall_faces(house, room)
        for hole in face.openings
        if hole.opening.kind == "window"
    ]


def _covered(face: WallFace, hole: FaceOpening, seed: int) -> list[JoinedGroup]:
    geometry = Geometry()
    palette = draw_palette(generator(seed))
    add_covering(geometry, face, hole, palette, generator(seed))
    return list(geometry.joined().values())


@pytest.mark.parametrize("seed", range(24))
def test_a_covering_hangs_before_its_window_and_keeps_clear_of_other_openings(seed: int) -> None:
    windows = _windows()
    face, hole = windows[seed % len(windows)]
    (group,) = _covered(face, hole, seed)
    assert (group.labels == OTHER).all()
    inverse = np.linalg.inv(face.frame(0))
    local = group.solid.vertices @ inverse[:3, :3].T + inverse[:3, 3]
    x, y, z = local.T
    assert x.min() >= -1e-6 and x.max() <= face.length + 1e-6
    assert y.min() > 0 and y.max() < face.height
    assert x.min() <= hole.left + 0.15 and x.max() >= hole.right - 0.15  # vanes are whole
    assert y.max() >= hole.top - 0.05 and y.min() <= hole.top - 0.3 * (hole.top - hole.bottom)
    assert z.min() > -face.inset - 0.5 * OUTER_REVEAL and z.max() < 0.2  # inside of the glass
    for other in face.openings:
        if other is not hole:
            assert x.max() <= other.left or x.min() >= other.right


def test_kinds_reach_from_one_sheet_to_dozens_of_slats() -> None:
    assert set(COVERINGS) == {"slats", "vanes", "sheet", "curtains"}
    face, hole = _windows()[0]
    counts = {len(_covered(face, hole, seed)[0].solid.faces) for seed in range(40)}
    assert min(counts) == 12  # a sheet is one box
    assert max(counts) > 300  # a Venetian blind has dozens of slats
