"""Room names in six languages tell the type."""

import pytest

from plan2scene.house import ROOM_TYPES
from plan2scene.plans.room_names import room_types


@pytest.mark.parametrize(
    ("name", "types"),
    [
        ("Master bedroom 2", ("Bedroom",)),
        ("Bathroom", ("Bathroom",)),
        ("Salle de bains", ("Bathroom",)),
        ("WC", ("Bathroom",)),
        ("Küche/Essen", ("Kitchen", "Reception")),
        ("Living / Kitchen", ("Reception", "Kitchen")),
        ("Wohnzimmer", ("Reception",)),
        ("Schlafzimmer", ("Bedroom",)),
        ("Badezimmer", ("Bathroom",)),
        ("Flur", ("Corridor",)),
        ("Chambre 1", ("Bedroom",)),
        ("Séjour", ("Reception",)),
        ("Cuisine", ("Kitchen",)),
        ("Baño", ("Bathroom",)),
        ("Dormitorio principal", ("Bedroom",)),
        ("Cocina", ("Kitchen",)),
        ("Soggiorno", ("Reception",)),
        ("Camera da letto", ("Bedroom",)),
        ("Ripostiglio", ("Closet",)),
        ("Slaapkamer", ("Bedroom",)),
        ("Keuken", ("Kitchen",)),
        ("Woonkamer", ("Reception",)),
        ("LivingRoom", ("Reception",)),
        ("BALCONY", ("Balcony",)),
        ("", ()),
        ("Zone 51", ()),
    ],
)
def test_names(name, types):
    assert room_types(name) == types


@pytest.mark.parametrize("name", [name for name in ROOM_TYPES if name != "Unknown"])
def test_the_types_mean_themselves(name):
    assert room_types(name) == (name,)
