from dataclasses import replace

import pytest
from box_room import box_house, shot
from sample_houses import with_openings

from plan2scene.photos.labels.palette import WALL, WINDOW
from plan2scene.photos.locate.locate_photos import locate_shots
from plan2scene.photos.locate.plan_view import UNDRAWN, room_shapes, searched_shapes
from plan2scene.plans.usual_windows import guesses_windows, with_usual_windows
from plan2scene.plans.validate import validate_house
from plan2scene_app.heights.seen_windows import with_seen_windows

TRUE = box_house()
VIEWS = [
    (-20.0, (3.2, 1.4, 0.7)),
    (-40.0, (1.6, 1.5, 0.8)),
    (115.0, (4.2, 1.4, 2.0)),
    (125.0, (4.3, 1.5, 2.9)),
    (-70.0, (1.0, 1.5, 2.9)),
]


def undrawn():
    walls = tuple(
        replace(wall, openings=tuple(o for o in wall.openings if o.kind != "window"))
        for wall in TRUE.walls
    )
    return with_usual_windows(replace(TRUE, walls=walls))


def shots(house, *, shown=True):
    found = {}
    for number, view in enumerate(VIEWS):
        photo, _ = shot(house, *view, pitch_deg=3.0, fov_deg=80.0)
        photo.labels[(photo.labels == WINDOW) & (not shown)] = WALL
        found[f"{number}.jpg"] = photo
    return found


def test_windows_lie_where_photos_show_them():
    house = undrawn()
    assert guesses_windows(house)
    photos = shots(TRUE)
    poses = locate_shots(TRUE, photos).poses
    doors = with_openings(TRUE, lambda o: o.kind == "window", kind="door", bottom=0.0, end=2.46)
    beside_doors = with_seen_windows(with_usual_windows(doors), photos, poses)
    assert not guesses_windows(beside_doors) and "apart" not in str(validate_house(beside_doors))
    seen = with_seen_windows(house, photos, poses)
    assert not guesses_windows(seen)
    true = {wall.id: [o for o in wall.openings if o.kind == "window"] for wall in TRUE.walls}
    for wall in seen.walls:
        windows = [o for o in wall.openings if o.kind == "window"]
        assert len(windows) == len(true[wall.id])
        for found, told in zip(windows, true[wall.id], strict=True):
            for value in ("start", "end", "bottom", "top"):
                assert getattr(found, value) == pytest.approx(getattr(told, value), abs=0.06)


def test_what_ends_low_or_has_no_wall_is_no_window():
    photos = shots(TRUE)
    poses = locate_shots(TRUE, photos).poses
    house = undrawn()
    open_side = replace(house, walls=tuple(wall for wall in house.walls if wall.id != "w3"))
    seen = with_seen_windows(open_side, photos, poses)
    assert {w.id for w in seen.walls for o in w.openings if o.kind == "window"} == {"w2"}
    low = with_openings(TRUE, lambda o: o.kind == "window", bottom=0.5, top=1.3)
    photos = shots(low)
    assert with_seen_windows(undrawn(), photos, locate_shots(low, photos).poses) == undrawn()


def test_rooms_without_a_window_in_photos_keep_their_guess():
    house = undrawn()
    photos = shots(house, shown=False)
    assert with_seen_windows(house, photos, locate_shots(TRUE, photos).poses) == house
    assert with_seen_windows(house, photos, {}) == house


def test_only_walls_to_the_outside_may_have_windows_that_no_plan_draws():
    spans = [hole for hole in searched_shapes(undrawn())["room"].holes if hole.kind == UNDRAWN]
    assert {hole.edge for hole in spans} == {0, 1, 2, 3}
    assert next(hole for hole in spans if hole.edge == 1).start > 1.8  # the store is 2 m long
    assert all(hole.kind != UNDRAWN for hole in searched_shapes(TRUE)["room"].holes)
    assert room_shapes(TRUE)["room"].holes == searched_shapes(TRUE)["room"].holes
