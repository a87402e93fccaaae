import numpy as np
import torch

from plan2scene.photos.labels import imagenet, things
from plan2scene.photos.labels.labeller import labeller
from plan2scene.photos.labels.palette import KINDS, write_label_png

STOVE, BATHTUB, LAKE = 827, 435, 975


def _kind(kinds):
    return KINDS[int(kinds.argmax())]


class _Colours(torch.nn.Module):
    """Sees a stove in red, a bathtub in blue, a lake in green, cell by cell, nothing in grey."""

    def __init__(self):
        super().__init__()
        self._fc = torch.nn.Linear(3, 1000)
        torch.nn.init.zeros_(self._fc.weight)
        torch.nn.init.zeros_(self._fc.bias)
        with torch.no_grad():
            self._fc.bias[0] = 10.0
            self._fc.weight[STOVE, 0] = self._fc.weight[BATHTUB, 2] = 20.0
            self._fc.weight[LAKE, 1] = 20.0

    def extract_features(self, photo):
        assert photo.shape[1] == 3 and photo.abs().max() <= 1.0
        return torch.nn.functional.avg_pool2d(photo, 32)


def test_a_photo_looks_like_the_mean_of_its_cells_and_is_outside_where_much_of_it_is():
    photo = np.full((320, 448, 3), 127, np.uint8)
    photo[:, 224:] = (255, 127, 127)
    np.testing.assert_allclose(things.ThingKinds(_Colours()).look(photo), [0.5, 0, 0], atol=0.01)
    photo = np.full((320, 448, 3), 100, np.uint8)
    told = things.ThingKinds(_Colours())
    assert not told.outside(photo)
    photo[:, 112:] = (20, 230, 20)
    assert told.outside(photo)


def test_a_thing_shows_in_a_part_of_a_photo_and_not_in_a_dot():
    grey = np.full((480, 640, 3), 100, np.uint8)
    teller = things.ThingKinds(_Colours())
    np.testing.assert_allclose(teller.probabilities(grey), 1 / len(KINDS), atol=1e-6)
    for colour, kind in (((255, 0, 0), "Kitchen"), ((0, 0, 255), "Bathroom")):
        large, dot = grey.copy(), grey.copy()
        large[200:, 100:500] = colour
        dot[200:216, 100:116] = colour
        assert _kind(teller.probabilities(large)) == kind
        assert teller.probabilities(large).max() > 0.8
        np.testing.assert_allclose(teller.probabilities(dot), teller.probabilities(grey), atol=0.01)
        large[200:, 100:300] = (0, 0, 255) if kind == "Kitchen" else (255, 0, 0)
        assert teller.probabilities(large).max() < 0.8  # a stove beside a bathtub


def test_the_kinds_of_a_labeller_are_those_of_things(tmp_path, monkeypatch):
    monkeypatch.setattr(imagenet, "load_imagenet", _Colours)
    write_label_png(tmp_path / "a.png", np.zeros((64, 96), np.uint8))
    found = labeller("precomputed", precomputed_dir=tmp_path, things=True, house_id="h")
    red = np.full((64, 96, 3), (255, 0, 0), np.uint8)
    assert found.kinds is not None and _kind(found.kinds(red)) == "Kitchen"
    assert not found.label("a.jpg", red, None).labels.any()
