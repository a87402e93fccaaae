import numpy as np
import pytest
import torch

from plan2scene.camera import Camera
from plan2scene.photos.labels.network import SegmentationNet
from plan2scene.photos.labels.palette import DOOR, WINDOW, without_openings
from plan2scene.photos.labels.segmentation import MEDIAN, Segmenter, brightened

TINY = {"widths": [8, 8, 8, 8, 8], "depths": [1, 1, 1, 1], "decoder": 16, "long_side": 64}


def _tiny():
    torch.manual_seed(0)
    return SegmentationNet(**TINY).eval()


def _photo(height, width, seed=0):
    return np.random.default_rng(seed).integers(0, 256, (height, width, 3), dtype=np.uint8)


def test_openings_are_told_where_they_are_asked_for_and_else_change_nothing():
    torch.manual_seed(0)
    network = SegmentationNet(**TINY, labels=6)
    image = _photo(50, 70)
    plain, told = (Segmenter(network).labels(image, openings=asked) for asked in (False, True))
    assert {DOOR, WINDOW} & set(np.unique(told).tolist())
    assert np.array_equal(without_openings(told), plain)
    four = Segmenter(_tiny())
    assert np.array_equal(four.labels(image, openings=True), four.labels(image))
    network.architecture["logit_adjustment"] = [0, 0, 0, 0, 9, 0]
    after, doors = (Segmenter(network).labels(image, openings=asked) for asked in (False, True))
    assert np.array_equal(plain, after)
    assert (doors == DOOR).all() and not (told == DOOR).all()


def _colours(_, x, __):
    """Return logits that are the colours: red is floor, green wall, blue ceiling."""
    small = x[:, :, ::2, ::2]
    return torch.cat([torch.full_like(small[:, :1], 0.5), small], dim=1)


def test_mirrored_answers_come_back_where_they_belong(monkeypatch):
    network = _tiny()
    monkeypatch.setattr(SegmentationNet, "forward", _colours)
    image = np.zeros((48, 64, 3), np.uint8)
    image[:, :20, 0], image[:, 20:50, 1] = 255, 255
    labels = Segmenter(network).labels(image)
    assert (labels[:, :19] == 1).all() and (labels[:, 22:48] == 2).all()
    assert (labels[:, 52:] == 0).all()


def _camera(up):
    level = (1, 0, 0) if up[0] == 0 else (-up[1], up[0], 0)
    rotation = np.stack([level, up, np.cross(level, up)], 1)
    return Camera(64, 48, 40.0, 31.5, 23.5, tuple(map(tuple, rotation)), "config", 1.0, False)


def test_segmenter_tells_the_network_where_the_horizon_is():
    """A network that reads the elevation alone labels what is below the horizon floor."""
    network = SegmentationNet(**TINY, elevation=True).eval()
    seen: list[torch.Tensor] = []
    network.register_forward_pre_hook(lambda _m, args: seen.append(args[1]))
    tilt = np.deg2rad(10)  # looks down: the horizon is above the middle
    Segmenter(network).labels(_photo(48, 64), _camera((0.0, -np.cos(tilt), -np.sin(tilt))))
    elevation = seen[0][0].numpy()
    below = elevation < 0
    horizon = 48 / 2 - 40 * np.tan(tilt)  # rows of the photo
    rows = (np.arange(elevation.shape[0]) + 0.5) / elevation.shape[0] * 48
    assert np.array_equal(below.all(axis=1), rows > horizon)


def test_dim_photos_are_brightened_and_others_are_not():
    ramp = np.tile(np.arange(256, dtype=np.uint8)[None, :, None], (8, 1, 3))
    dim = (ramp * 0.2).astype(np.uint8)
    assert np.median(brightened(dim)) / 255 == pytest.approx(MEDIAN, abs=0.02)
    assert (np.diff(brightened(dim)[0, :, 0].astype(int)) >= 0).all()
    assert np.array_equal(brightened(ramp), ramp)
    assert np.array_equal(brightened(ramp * 0), ramp * 0)  # nothing to see
