import itertools
from dataclasses import replace

import numpy as np
import pytest
from sample_houses import rooms_in_a_row

from plan2scene.house import House, Opening, Wall
from plan2scene.photos.labels.palette import KINDS
from plan2scene.photos.locate.which_room import (
    NOWHERE,
    Likely,
    PhotoEvidence,
    fitting_rooms,
    likely_room,
    room_probabilities,
    used_photos,
)


def home():
    """Two bedrooms of one size, a kitchen and a bath."""
    rooms = dict(bed_1="Bedroom", bed_2="Bedroom", kitchen="Kitchen", bath="Bathroom")
    window = Opening("w", "window", 1.0, 2.0, 0.9, 2.1)
    walls = (Wall("wall", ("bed_1",), (0.0, 0.0), (3.0, 0.0), 2.5, openings=(window,)),)
    return House("h", rooms_in_a_row(**rooms), walls)


def looks_like(kind, sure=0.9):
    """The kinds of a photo of which the classifier is so sure."""
    kinds = np.full(len(KINDS), (1 - sure) / (len(KINDS) - 1))
    kinds[KINDS.index(kind)] = sure
    return kinds


BEDROOM = PhotoEvidence(kinds=looks_like("Bedroom"))


def rooms_of(photos, tied=(), alike=None):
    return room_probabilities(home(), photos, tied, alike or {})


def test_what_a_room_is_used_for_and_its_name_tell_it():
    kitchen = PhotoEvidence(kinds=looks_like("Kitchen"))
    photos = {"a": kitchen, "b": PhotoEvidence(named={"bath": 1.0}), "d": PhotoEvidence()}
    nowhere = PhotoEvidence(kinds=np.zeros(len(KINDS)), scores={"bed_1": 9.0})
    found = rooms_of(photos | {"c": PhotoEvidence(told=("bed_2",)), "e": nowhere})
    likely = {name: likely_room(home(), rooms) for name, rooms in found.items()}
    assert likely["a"].room_id == "kitchen" and likely["b"].room_id == "bath"
    assert found["c"] == {"bed_2": 1.0} and found["d"] == {NOWHERE: 1.0}
    assert likely["e"] == (NOWHERE, 1.0, 1.0)
    for name in "ab":
        assert sum(found[name].values()) == pytest.approx(1.0, abs=1e-3)
    assert rooms_of({"a": kitchen}) == rooms_of({"a": kitchen})


def test_photos_that_look_alike_are_of_one_room():
    photos = {name: BEDROOM for name in "bcd"}
    photos["a"] = PhotoEvidence(told=("bed_1",))
    pairs = itertools.combinations("abcd", 2)
    alike = {pair: 0.9 if pair in (("a", "b"), ("c", "d")) else -0.5 for pair in pairs}
    for found, wins in ((rooms_of(photos, (), alike), True), (rooms_of(photos), False)):
        assert (found["b"]["bed_1"] > 0.6 > 0.4 > found["c"]["bed_1"]) is wins


def test_photos_of_one_storey_look_sooner_alike():
    photos = {"bed": BEDROOM, "kitchen": PhotoEvidence(told=("kitchen",))}
    one = home()
    rooms = [replace(r, level="low" if r.id in ("bed_1", "kitchen") else "high") for r in one.rooms]
    alike = {("bed", "kitchen"): 0.8}
    for house, wins in ((replace(one, rooms=tuple(rooms)), True), (one, False)):
        found = room_probabilities(house, photos, (), alike)["bed"]
        assert (found["bed_1"] > 1.3 * found["bed_2"]) is wins


def test_of_rooms_of_a_type_the_larger_one_is_photographed_more():
    small = home()
    ring = ((3.0, 0.0), (6.0, 0.0), (6.0, 9.0), (3.0, 9.0))
    rooms = [replace(r, rings=(ring,)) if r.id == "bed_2" else r for r in small.rooms]
    large = replace(small, rooms=tuple(rooms))
    photos = {name: BEDROOM for name in "abc"}
    same, more = (room_probabilities(house, photos, (), {})["a"] for house in (small, large))
    assert same["bed_1"] == pytest.approx(same["bed_2"], abs=0.05)
    assert more["bed_2"] > 1.2 * more["bed_1"]


@pytest.mark.parametrize(
    ("name", "fits"),
    [
        ("bath_2", {"bath": 1.0}),
        ("salle-de-bain1", {"bath": 1.0}),
        ("bedroom", {"bed_1": 1.0, "bed_2": 1.0}),
        ("MasterBedroom_3", {"bed_1": 0.5, "bed_2": 1.0}),
        ("mastersinks", {"bed_2": 1.0}),
        ("primarybedroom", {"bed_1": 0.5, "bed_2": 1.0}),
        ("IMG_2031 room", {}),
    ],
)
def test_a_name_fits_rooms_by_what_they_are_called_and_are(name, fits):
    house = home()
    rooms = [replace(r, name="MASTER") if r.id == "bed_2" else r for r in house.rooms]
    assert fitting_rooms(replace(house, rooms=tuple(rooms)), name) == fits


def test_photos_of_one_thing_are_of_one_room_and_others_sooner_of_another():
    told = {"a": PhotoEvidence(told=("bed_1",)), "b": BEDROOM}
    apart, together = rooms_of(told), rooms_of(told, [("a", "b")])
    assert likely_room(home(), apart["b"]).room_id == "bed_2"
    assert likely_room(home(), together["b"]).room_id == "bed_1"
    assert together["b"]["bed_1"] > 0.7 > apart["b"]["bed_1"]
    told = {name: PhotoEvidence(told=("bed_1",)) for name in "abcd"}
    told |= {"e": PhotoEvidence(told=("bed_2",)), "f": BEDROOM}
    apart, tied = rooms_of(told)["f"], rooms_of(told, [("a", "f")])["f"]
    assert apart["bed_2"] > 1.5 * apart["bed_1"] and tied["bed_1"] > 0.8


def test_photos_of_one_wall_are_not_sure_of_one_of_two_like_rooms():
    found = rooms_of({name: BEDROOM for name in "abcd"}, list(itertools.combinations("abcd", 2)))
    for name in "abcd":
        assert found[name]["bed_1"] == pytest.approx(found[name]["bed_2"], abs=0.15)


def test_a_photo_of_some_bedroom_is_used_where_no_surer_one_shows_that_room():
    some = likely_room(home(), {"bed_1": 0.2, "bed_2": 0.19, "kitchen": 0.1, NOWHERE: 0.05})
    assert some.of_kind == pytest.approx(0.39)
    some = some._replace(of_kind=0.6)
    sure = Likely("bed_1", 0.9, 0.95)
    assert used_photos({"a": some, "b": some._replace(of_kind=0.49)}, ()) == {"a"}
    # A photo of no clear kind is of no use, however it is with its room.
    assert used_photos({"a": some._replace(probability=0.3, of_kind=0.49)}, ()) == set()
    assert used_photos({"a": some, "c": sure}, ()) == {"c"}
    assert used_photos({"a": some}, {"bed_1"}) == set()
    # A guess that is much less probable than the best one is of another room.
    for probability, used in ((0.195, {"a", "b"}), (0.185, {"a"})):
        assert used_photos({"a": some, "b": some._replace(probability=probability)}, ()) == used


def test_places_count_more_the_more_they_differ():
    rooms = ("bed_1", "bed_2", "kitchen", "bath")
    sure = []
    for lead in (0.0, 0.05, 0.15):
        scores = {room: -1.0 - lead * (room != "bath") for room in rooms}
        sure.append(rooms_of({"a": PhotoEvidence(scores=scores)})["a"]["bath"])
    assert sure[0] < sure[1] < sure[2]
