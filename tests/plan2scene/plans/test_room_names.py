"""Room names in the languages of agents tell the type."""

import pytest

from plan2scene.plans.room_names import room_types


@pytest.mark.parametrize(
    ("name", "types"),
    [
        ("Master bedroom 2", ("Bedroom",)),
        ("Salle de bains", ("Bathroom",)),
        ("WC", ("Bathroom",)),
        ("Upstairs Bathroom", ("Bathroom",)),
        ("Küche/Essen", ("Kitchen", "Reception")),
        ("Living / Kitchen", ("Reception", "Kitchen")),
        ("Wohnzimmer", ("Reception",)),
        ("Zimmer 2", ("Bedroom",)),
        ("W/I CL", ("Closet",)),
        ("Séjour", ("Reception",)),
        ("Baño", ("Bathroom",)),
        ("Soggiorno", ("Reception",)),
        ("Camera da letto", ("Bedroom",)),
        ("Ripostiglio", ("Closet",)),
        ("Slaapkamer", ("Bedroom",)),
        ("Woonkamer", ("Reception",)),
        ("LivingRoom", ("Reception",)),
        ("BALCONY", ("Balcony",)),
        ("HWR", ("Unknown",)),
        ("Garage / WC", ("Bathroom",)),
        ("ST", ("Closet",)),
        ("Butler's pantry", ("Kitchen",)),
        ("Køkken", ("Kitchen",)),
        ("Makuuhuone 2", ("Bedroom",)),
        ("Sypialnia", ("Bedroom",)),
        ("Łazienka", ("Bathroom",)),
        ("Casa de banho", ("Bathroom",)),
        ("Yatak odası", ("Bedroom",)),
        ("Гостиная", ("Reception",)),
        ("Фасад", ()),
        ("חדר שינה", ("Bedroom",)),
        ("מטבח", ("Kitchen",)),
        ("洋室6帖", ("Bedroom",)),
        ("玄関ホール", ("Entrance",)),
        ("", ()),
        ("Zone 51", ()),
    ],
)
def test_names(name, types):
    assert room_types(name) == types
