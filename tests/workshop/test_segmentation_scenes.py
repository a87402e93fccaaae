from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plan2scene.images import write_png
from plan2scene.photos.labels.palette import CEILING, FLOOR, IGNORE, OTHER, WALL
from plan2scene_workshop.segmentation import furniture
from plan2scene_workshop.segmentation import paints as segmentation_paints
from plan2scene_workshop.segmentation import scenes as segmentation_scenes
from plan2scene_workshop.segmentation.bodies import (
    Body,
    Eye,
    Lamp,
    plain,
)
from plan2scene_workshop.segmentation.paints import Paints, random_paints
from plan2scene_workshop.segmentation.raycast import (
    Surfels,
    cast,
    surfels,
)
from plan2scene_workshop.segmentation.rooms import above, wall_trim
from plan2scene_workshop.segmentation.scenes import (
    random_scene_and_eye,
    random_scenes,
    random_scenes_and_eyes,
    scene_camera,
)
from plan2scene_workshop.segmentation.shading import Sun, contact, reflections, shadow, sunlight
from plan2scene_workshop.segmentation.spots import Spot, wall_spots

_WHITE = (plain(np.ones(3)),)


@pytest.fixture(scope="module")
def paints() -> Paints:
    """Return few tiles, drawn once."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(segmentation_paints, "TILES", 2)
        return random_paints(3)


def _room(half: tuple[float, float, float] = (2.0, 1.25, 3.0)) -> Body:
    labels = (WALL, WALL, FLOOR, CEILING, WALL, WALL)
    centre = np.array([0.0, half[1], 0.0])
    return Body(centre, np.array(half), 0.0, labels, _WHITE * 6, hollow=True)


def _eye(size: tuple[int, int] = (60, 80), focal: float = 40.0) -> Eye:
    look = np.diag([-1.0, -1.0, 1.0])  # along +z, so that +x is left
    return Eye(np.array([0.0, 1.25, -2.0]), look, focal, size)


def _labels(bodies: list[Body], eye: Eye) -> np.ndarray:
    rays = eye.rays()
    return surfels(bodies, eye, rays, cast(bodies, eye, rays)).label.reshape(eye.size)


def test_scenes_depend_on_seed_and_index_alone(paints: Paints) -> None:
    first, eye = random_scene_and_eye(paints, 4, seed=7)
    random_scene_and_eye(paints, 1, seed=7)
    again, eye_again = random_scene_and_eye(paints, 4, seed=7)
    other, _ = random_scene_and_eye(paints, 4, seed=8)
    assert np.array_equal(first.image, again.image)
    assert np.array_equal(first.labels, again.labels)
    assert np.array_equal(eye.rotation, eye_again.rotation)
    assert first.image.shape != other.image.shape or not np.array_equal(first.image, other.image)


def test_labels_of_scenes_are_those_of_the_geometry(paints: Paints) -> None:
    seen_floor = 0
    for index in range(6):
        photo, eye = random_scene_and_eye(paints, index, seed=11)
        assert photo.image.shape == (*eye.size, 3)
        assert photo.image.dtype == photo.labels.dtype == np.uint8
        assert set(np.unique(photo.labels).tolist()) <= {OTHER, FLOOR, WALL, CEILING, IGNORE}
        rise = eye.rays()[..., 1]
        # The eye is above the floor: floor is only where a ray falls.
        assert (rise[photo.labels == FLOOR] < 0).all()
        seen_floor += int((photo.labels == FLOOR).sum())
    assert seen_floor > 1000


def test_camera_of_a_scene_projects_as_the_conventions_say(paints: Paints) -> None:
    _, eye = random_scene_and_eye(paints, 2, seed=5)
    camera = scene_camera(eye)
    rotation = np.array(camera["rotation"])
    assert np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-6)
    assert np.linalg.det(rotation) == pytest.approx(1)
    # A point on the ray of pixel (row 10, column 20) comes back to that pixel.
    point = eye.position + 3 * eye.rays()[10, 20].astype(float)
    x, y, z = rotation @ (point - np.array(camera["position"]))
    assert camera["focal_px"] * x / z + camera["cx"] == pytest.approx(20, abs=1e-3)
    assert camera["focal_px"] * y / z + camera["cy"] == pytest.approx(10, abs=1e-3)
    assert (camera["height"], camera["width"]) == eye.size


def test_real_tiles_are_used_when_given_and_only_those_of_train(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(segmentation_paints, "TILES", 1)
    for name, colour in (("a", (250, 0, 0)), ("b", (0, 250, 0))):
        write_png(tmp_path / "wood" / f"{name}.png", np.full((32, 32, 3), colour, np.uint8))
    (tmp_path / "index.csv").write_text("id,split\na,train\nb,val\n")
    with_tiles = random_paints(1, tmp_path).tiles["wood"]
    assert len(with_tiles) == 2
    assert with_tiles[1].levels[-1].ravel() == pytest.approx([0.957, 0, 0], abs=0.01)
    assert len(random_paints(1).tiles["wood"]) == 1
    first, again = (random_scenes(1, seed=1, textures=tmp_path)[0] for _ in range(2))
    assert np.array_equal(first.image, again.image)


def test_no_scene_without_count() -> None:
    assert random_scenes_and_eyes(0, seed=1) == []


def test_a_stencil_lets_rays_pass_where_it_is_cut() -> None:
    stencil = np.zeros((2, 2), bool)
    stencil[0, 0] = True  # above, at low x: the right, as +x is left
    card = Body(
        np.array([0.0, 1.25, 0.0]),
        np.array([0.5, 0.5, 0.004]),
        0.0,
        (OTHER,),
        _WHITE,
        stencil=stencil,
    )
    labels = _labels([_room(), card], _eye())
    rows, columns = np.nonzero(labels == OTHER)
    assert len(rows) > 50
    assert rows.max() <= 30
    assert columns.min() >= 39


def test_an_open_door_shows_the_room_beyond() -> None:
    wall = Spot(0.0, 3.0, np.pi)  # the far wall
    beyond = Body(
        np.array([0.0, 1.25, 5.0]),
        np.array([1.0, 1.25, 2.0]),
        0.0,
        (WALL, WALL, FLOOR, CEILING, OTHER, OTHER),
        _WHITE * 6,
        hollow=True,
    )
    plate = wall.part((0, 1.0, 0), (0.8, 2.0, 0.06), _WHITE[0])
    door = Body(plate.centre, plate.half, plate.yaw, (OTHER,), _WHITE, beyond=beyond)
    bodies = [_room(), door, beyond]
    eye = _eye()
    rays = eye.rays()
    seen = surfels(bodies, eye, rays, cast(bodies, eye, rays))
    point = seen.point.reshape(60, 80, 3)
    labels = seen.label.reshape(60, 80)
    assert labels[29, 40] == OTHER  # its end wall, nine metres away
    assert point[29, 40, 2] == pytest.approx(7.0, abs=1e-3)
    assert labels[38, 40] == FLOOR
    assert point[38, 40, 2] > 3.1
    assert labels[29, 50] == WALL
    assert point[29, 50, 2] == pytest.approx(3.0, abs=1e-3)


def test_slopes_count_as_ceiling_and_trim_as_wall(paints: Paints) -> None:
    room = _room()
    labels, tilted = set(), 0
    for seed in range(40):
        bodies, _ = above(room, paints, np.random.default_rng(seed))
        for body in bodies:
            labels |= set(body.labels)
            if body.tilt:
                tilted += 1
                assert body.labels == (CEILING,)
                # Its lower face looks down into the room.
                assert (-body.turn[1])[1] < 0
                assert np.dot((-body.turn[1])[[0, 2]], -body.centre[[0, 2]]) > 0
        trim = wall_trim(room, paints, np.random.default_rng(seed))
        assert {label for body in trim for label in body.labels} <= {WALL, IGNORE}
    assert tilted
    assert labels == {CEILING, OTHER}


def test_furniture_is_other_and_stands_above_the_floor(paints: Paints) -> None:
    makers = {make for kind in furniture._ROOMS.values() for make in kind}
    assert len(makers) == 15
    for make in sorted(makers, key=lambda maker: maker.__name__):
        for seed in range(4):
            bodies = make(Spot(0.3, -0.2, 0.7), paints, np.random.default_rng(seed))
            assert bodies
            assert {label for body in bodies for label in body.labels} == {OTHER}
            lowest = min(float((b.centre - np.abs(b.turn.T) @ b.half)[1]) for b in bodies)
            assert -0.12 < lowest < 0.3, make.__name__


def test_walls_face_the_room() -> None:
    for spot, length in wall_spots(np.array([2.0, 1.25, 3.0])):
        front = spot.world((0.0, 1.0, 0.5))
        assert np.abs(front[[0, 2]] / [2.0, 3.0]).max() < 1
        assert length in (4.0, 6.0)


def test_sun_falls_only_through_the_pane_and_not_through_things() -> None:
    room, eye = _room(), _eye()
    pane = Spot(0.0, 3.0, np.pi).part((0, 1.5, 0), (1.0, 1.0, 0.06), _WHITE[0], glow=1.0)
    sun = Sun(np.array([0.0, 1.0, 1.0]), np.ones(3), (pane,))
    rays = eye.rays()
    bodies = [room, pane]
    seen = surfels(bodies, eye, rays, cast(bodies, eye, rays))
    light = sunlight(bodies, seen, sun)
    lit = seen.point[light > 0]
    # Rays that rise at 45 degrees to the pane at z 3, y 1..2, leave the floor at z 1..2.
    assert len(lit) > 20
    assert lit[:, 2].min() > 0.95
    assert lit[:, 2].max() < 2.05
    assert np.abs(lit[:, 0]).max() < 0.55
    assert light.max() == pytest.approx(np.sqrt(0.5), abs=1e-3)
    lid = Body(np.array([0.0, 0.6, 2.1]), np.array([2.0, 0.02, 1.0]), 0.0, (OTHER,), _WHITE)
    covered = sunlight([*bodies, lid], seen, sun)
    assert covered.sum() < 0.3 * light.sum()


def test_a_mirror_shows_what_is_behind_the_camera() -> None:
    red = plain(np.array([0.9, 0.0, 0.0]))
    room = _room()
    paints = list(room.paints)
    paints[4] = red  # the wall at -z, behind the eye
    room = Body(room.centre, room.half, 0.0, room.labels, tuple(paints), hollow=True)
    mirror = Spot(0.0, 3.0, np.pi).part((0, 1.25, 0), (1, 1, 0.04), _WHITE[0], mirror=0.95)
    eye = _eye()
    rays = eye.rays()
    seen = surfels([room, mirror], eye, rays, cast([room, mirror], eye, rays))
    share, picture = reflections([room, mirror], seen, eye, np.ones(3))
    middle = 30 * 80 + 40
    assert share[middle] == pytest.approx(0.95)
    assert picture[middle, 0] > 0.3
    assert picture[middle, 1] == pytest.approx(0)
    assert share[0] == 0


def test_a_shadow_is_even_under_a_thing_and_absent_elsewhere() -> None:
    room, eye = _room(), _eye((120, 160), 80.0)
    thing = Body(np.array([0.0, 0.8, 1.5]), np.array([0.6, 0.05, 0.6]), 0.0, (OTHER,), _WHITE)
    rays = eye.rays()
    seen = surfels([room, thing], eye, rays, cast([room, thing], eye, rays))
    lamp = Lamp(np.array([0.0, 2.4, 1.5]), np.ones(3), 0.1)
    lit = shadow([room, thing], seen, eye, lamp, np.random.default_rng(0)).ravel()
    floor = seen.label == FLOOR
    below = np.abs(seen.point - [0, 0, 1.5]).max(axis=1) < 0.5
    away = np.abs(seen.point[:, 0]) > 1.6
    assert (floor & below).sum() > 50
    assert lit[floor & below].mean() < 0.25
    assert lit[floor & away].min() > 0.99


def test_floor_darkens_towards_what_stands_on_it() -> None:
    room, eye = _room(), _eye((120, 160), 80.0)
    thing = Body(np.array([0.0, 0.3, 1.5]), np.full(3, 0.3), 0.0, (OTHER,), _WHITE)
    rays = eye.rays()
    seen = surfels([room, thing], eye, rays, cast([room, thing], eye, rays))
    share = contact([room, thing], seen, eye)
    away = np.abs(seen.point[:, 0])
    beside = (seen.label == FLOOR) & (np.abs(seen.point[:, 2] - 1.5) < 0.2)
    assert share[beside & (away < 0.4)].mean() < 0.9  # 0.85 at 0.1 m, before the blur
    assert share[beside & (away > 1.5)].min() > 0.99
    assert (share[seen.label == OTHER] == 1).all()


def test_labels_lie_on_the_surfaces_they_name(
    paints: Paints, monkeypatch: pytest.MonkeyPatch
) -> None:
    taken: list[Surfels] = []

    def kept(*args: Any) -> Surfels:
        taken.append(surfels(*args))
        return taken[-1]

    monkeypatch.setattr(segmentation_scenes, "surfels", kept)
    walls, level = 0, 0
    for index in range(6):
        photo, _ = random_scene_and_eye(paints, index, seed=23)
        seen = taken[-1]
        assert np.array_equal(seen.label, photo.labels.ravel())
        assert np.isfinite(seen.point).all()
        # Floors are at y 0 (a polish lies a millimetre above), ceilings are overhead.
        assert np.abs(seen.point[seen.label == FLOOR][:, 1]).max(initial=0) < 0.002
        assert seen.point[seen.label == CEILING][:, 1].min(initial=9) > 0.5
        walls += int((seen.label == WALL).sum())
        level += int((np.abs(seen.normal[seen.label == WALL][:, 1]) > 0.1).sum())
    assert walls > 1000
    assert level < 0.01 * walls  # only the tops of skirtings and dados
