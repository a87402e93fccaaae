"""What surfaces are of."""

import numpy as np

from plan2scene.house import SUBSTANCES
from plan2scene.propagation.substances import on_surfaces, usual_shares


def test_the_surface_says_which_substances_are_likely() -> None:
    woolly = np.tile(np.array([[0.02, 0.28, 0.68, 0.02]], np.float32), (3, 1))
    found = on_surfaces(woolly, ["floor", "wall", "ceiling"])
    assert [SUBSTANCES[k] for k in found.argmax(1)] == ["carpet", "plaster", "plaster"]
    np.testing.assert_allclose(found.sum(1), 1.0, rtol=1e-5)
    tiled = np.array([[0.001, 0.0001, 0.0001, 0.9988]], np.float32)
    assert SUBSTANCES[int(on_surfaces(tiled, ["wall"]).argmax())] == "tile"


def test_floors_of_bathrooms_are_tiled_unless_something_says_otherwise() -> None:
    tile = SUBSTANCES.index("tile")
    assert usual_shares("floor", ["Bathroom"]).argmax() == tile
    assert usual_shares("floor", ["Bedroom"]).argmax() == SUBSTANCES.index("wood")
    np.testing.assert_array_equal(usual_shares("wall", ["Bathroom"]), usual_shares("wall"))
    both = usual_shares("floor", ["Bathroom", "Bedroom"])
    assert usual_shares("floor")[tile] < both[tile] < usual_shares("floor", ["Bathroom"])[tile]
    for types in ([], ["Bathroom"], ["Balcony"], ["Bathroom", "Balcony"]):
        assert abs(usual_shares("floor", types).sum() - 1) < 1e-9
