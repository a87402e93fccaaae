"""Room names in the languages of agents tell the type."""

import pytest

from plan2scene.plans.room_names import has_bare_floor, is_garage, room_types

NAMES = {
    ("Bedroom",): "Master bedroom 2|Zimmer 2|Camera da letto|Slaapkamer|Makuuhuone 2|Sypialnia"
    "|Yatak odası|חדר שינה|洋室6帖|BDRM 2|BR1|M.BED|Schlafz.|Dorm. 2|ALK|Eltern",
    ("Bathroom",): "Salle de bains|WC|Upstairs Bathroom|Baño|Garage / WC|Łazienka|Casa de banho"
    "|PWDR|PDR RM|ENS.|W.C.|KH|SdB|Gästebad",
    ("Reception",): "Wohnzimmer|Séjour|Soggiorno|Woonkamer|LivingRoom|Гостиная|FAM RM|Sogg.",
    ("Kitchen",): "Butler's pantry|BUTLERS PANTRY|KIT|K|Køkken|מטבח",
    ("Closet",): "W/I CL|W/I A|Ripostiglio|ST|W.I.R.|WIC|P'TRY|CUPB'D|Abstellr.",
    ("Kitchen", "Reception"): "Küche/Essen",
    ("Reception", "Kitchen"): "Living / Kitchen",
    ("Balcony",): "BALCONY|PARV.",
    ("Entrance",): "玄関ホール",
    ("Unknown",): "HWR|L'DRY|L’DRY|LDRY|L.DRY|LNDRY|GAR.",
    (): "Фасад||Zone 51",
}


@pytest.mark.parametrize("types", NAMES)
def test_names(types):
    names = NAMES[types].split("|")
    assert {name: room_types(name) for name in names} == dict.fromkeys(names, types)


@pytest.mark.parametrize(
    ("name", "garage"),
    [("Double Garage", True), ("GARAJE", True), ("Garage / WC", False), ("Garden", False)],
)
def test_a_garage_is_told_by_its_name(name, garage):
    assert is_garage(name) is garage


@pytest.mark.parametrize(
    ("name", "types", "bare"),
    [
        ("Kök", ("Kitchen",), True),
        ("L'DRY", ("Unknown",), True),
        ("Entry", ("Entrance",), True),
        ("Kitchen / Living", ("Kitchen", "Reception"), False),
        ("Study", ("Unknown",), False),
    ],
)
def test_rooms_without_a_carpet_are_told_by_types_or_name(name, types, bare):
    assert has_bare_floor(types, name) is bare
