from itertools import pairwise

import pytest

from plan2scene_app.workflow.drops import SWEEP_DROPS, hidden_photos

NAMES = [f"{i}.jpg" for i in range(10)]
LISTED = {"0.0": [], "0.2": ["3.jpg", "7.jpg", "other.jpg"], "0.6": NAMES[2:8]}


def _hidden(listed, drop, house="h"):
    return hidden_photos(listed, drop, NAMES, seed=0, house_id=house)


@pytest.mark.parametrize("listed", [LISTED, None])
def test_fractions_of_the_list_are_the_list_s_and_others_lie_between(listed):
    assert _hidden(LISTED, "0.0") == [] and _hidden(LISTED, "0.2") == ["3.jpg", "7.jpg"]
    assert _hidden(LISTED, "0.6") == NAMES[2:8]
    hidden = {drop: set(_hidden(listed, drop)) for drop in SWEEP_DROPS}
    assert [len(names) for names in hidden.values()] == list(range(11))
    for smaller, larger in pairwise(SWEEP_DROPS):
        assert hidden[smaller] < hidden[larger]
    own, other = (_hidden(listed, "0.8", house=house) for house in ("one", "another"))
    assert own != other
