import numpy as np
import pytest
from box_room import SIZE, box_house, shot
from views import camera_looking

from plan2scene.photos.camera.calibration import canonical
from plan2scene.photos.locate.locate_photos import locate_shots
from plan2scene.photos.locate.spots import spots_of
from plan2scene.photos.matches import (
    Points,
    colours_of,
    find_points,
    likeness,
    matched_rays,
    same_spot,
    same_things,
)

#: Headings of photos, degrees, and how their frames turn into each other.
HEADINGS = {"a": 10.0, "b": 62.0, "c": 118.0}
FOCAL = 150.0
LENS = dict(pitch_deg=4.0, fov_deg=2 * np.degrees(np.arctan(SIZE[1] / 2 / FOCAL)))


def photographed(eye, heading_deg, points, looks):
    """The points (n, 3) that a photo shows, and its camera, which knows its frame only."""
    true = camera_looking(SIZE, heading_deg=heading_deg, pitch_deg=4.0, focal=FOCAL)
    rays = (points - eye) @ true.matrix.T
    pixels = rays[:, :2] / rays[:, 2:] * true.focal_px + (true.cx, true.cy)
    shown = (rays[:, 2] > 0) & ((pixels >= 0) & (pixels < SIZE[::-1])).all(axis=1)
    known = true.with_rotation(canonical(true.matrix))
    return Points(pixels[shown].astype(np.float32), looks[shown]), known


def turn_of(heading_deg):
    true = camera_looking(SIZE, heading_deg=heading_deg, pitch_deg=4.0, focal=FOCAL)
    ahead, own = true.matrix[2], canonical(true.matrix)[2]
    return round((np.arctan2(ahead[0], ahead[2]) - np.arctan2(own[0], own[2])) / (np.pi / 2))


@pytest.mark.parametrize(
    ("shared", "moved", "tied"), [(same_spot, 0.0, 2), (same_spot, 1.5, 0), (same_things, 1.5, 2)]
)
def test_photos_are_tied_by_quarter_turns(shared, moved, tied):
    rng = np.random.default_rng(0)
    points = rng.uniform((-4, -1.3, -4), (4, 1.3, 4), (1500, 3))
    looks = rng.normal(size=(1500, 128)).astype(np.float32)
    looks /= np.linalg.norm(looks, axis=1, keepdims=True)
    shots = {
        name: photographed(np.array([moved * k, 0.0, 0.0]), heading, points, looks)
        for k, (name, heading) in enumerate(HEADINGS.items())
    }
    parts = ({name: shot[part] for name, shot in shots.items()} for part in (0, 1))
    found = shared(list(matched_rays(*parts)))
    turns = {name: turn_of(heading) for name, heading in HEADINGS.items()}
    pairs = [("a", "b"), ("b", "c")][:tied]
    assert found == {pair: (turns[pair[1]] - turns[pair[0]]) % 4 for pair in pairs}
    assert len(set(turns.values())) > 1


def test_a_watermark_and_things_that_do_not_match_tie_no_photos():
    rng = np.random.default_rng(1)
    looks = np.eye(128, dtype=np.float32)[:40]
    mark = Points(rng.uniform(20, 160, (40, 2)).astype(np.float32), looks)
    camera = photographed(np.zeros(3), 0.0, np.zeros((0, 3)), looks[:0])[1]
    for shared in (same_spot, same_things):
        assert shared(list(matched_rays({"a": mark, "b": mark}, dict.fromkeys("ab", camera)))) == {}
    chance = {n: Points(rng.uniform(20, 160, (40, 2)).astype(np.float32), looks) for n in "ab"}
    assert same_things(list(matched_rays(chance, dict.fromkeys("ab", camera)))) == {}


def test_spots_follow_ties_while_a_room_is_common():
    rooms = {"a": ("hall", "bath"), "b": ("hall",), "c": ("hall", "bed"), "d": ("bed",)}
    first, last = spots_of(rooms, {("a", "b"): 3, ("b", "c"): 2, ("c", "d"): 1, ("a", "gone"): 0})
    assert first.quarters == {"a": 0, "b": 3, "c": 1} and first.rooms == ("hall",)
    assert (last.quarters, last.rooms) == ({"d": 0}, ("bed",))


def test_points_of_one_wall_are_found_again_but_not_a_watermark():
    rng = np.random.default_rng(0)
    blocks, other = (
        np.kron(rng.integers(0, 255, (60, 80, 3)), np.ones((8, 8, 1))).astype(np.uint8)
        for _ in range(2)
    )
    marked = other.copy()
    marked[100:200, 100:260] = blocks[100:200, 100:260]
    photos = {"a": blocks[:400, :560], "b": blocks[20:420, 60:620], "c": marked[:400, :560]}
    camera = camera_looking((400, 560), heading_deg=0.0, pitch_deg=0.0, focal=400.0)
    points = {name: find_points(image) for name, image in photos.items()}
    assert same_things(list(matched_rays(points, dict.fromkeys(photos, camera)))) == {("a", "b"): 0}


def test_a_photo_that_sees_what_another_sees_has_a_heading_that_goes_with_it():
    house = box_house()
    places = {"clear.jpg": (60.0, (4.2, 1.3, 0.7)), "corner.jpg": (15.0, (0.6, 1.5, 2.9))}
    found = {name: shot(house, *place, **LENS) for name, place in places.items()}
    shots = {name: photo for name, (photo, _) in found.items()}
    turned = {("clear.jpg", "corner.jpg"): (turn_of(15.0) - turn_of(60.0)) % 4}
    alone = locate_shots(house, shots).poses
    tied = locate_shots(house, shots, same_things=turned).poses
    assert not alone["corner.jpg"].believed and tied["corner.jpg"].believed
    true = found["corner.jpg"][1].matrix
    np.testing.assert_allclose(tied["corner.jpg"].camera.matrix, true, atol=1e-6)


def test_a_photo_that_tells_nothing_is_located_by_another_of_its_spot():
    house, eye = box_house(), np.array([0.6, 1.5, 2.9])
    views = {"clear.jpg": 230.0, "blank.jpg": 15.0}
    found = {name: shot(house, heading, eye, **LENS) for name, heading in views.items()}
    shots = {name: photo for name, (photo, _) in found.items()}
    blank = shots["blank.jpg"]
    quarters = {("blank.jpg", "clear.jpg"): (turn_of(230.0) - turn_of(15.0)) % 4}
    alone = locate_shots(house, {"blank.jpg": blank}).poses["blank.jpg"]
    together = locate_shots(house, shots, same_spot=quarters).poses
    assert not alone.believed and together["blank.jpg"].believed
    for name, (_, true) in found.items():
        np.testing.assert_allclose(together[name].camera.matrix, true.matrix, atol=1e-6)
        np.testing.assert_allclose(together[name].eye, eye, atol=0.1)


def test_photos_of_the_same_colours_look_alike_whatever_the_home_has_in_common():
    rng = np.random.default_rng(0)
    photos = {}
    for name, colour in {"a": (200, 40, 40), "b": (200, 40, 40), "c": (40, 40, 200)}.items():
        photo = np.full((60, 80, 3), 235, np.uint8)  # white walls in all
        photo[: int(rng.integers(20, 30))] = colour
        photos[name] = [colours_of(photo)]
    found = likeness(photos)
    assert list(found) == [("a", "b"), ("a", "c"), ("b", "c")]
    assert found["a", "b"] > 0.8 and max(found["a", "c"], found["b", "c"]) < -0.8
    assert likeness({name: looks * 2 for name, looks in photos.items()}) == pytest.approx(found)
    assert likeness({}) == likeness({"a": photos["a"]}) == {}
