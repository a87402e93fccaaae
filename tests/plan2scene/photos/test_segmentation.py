from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
import torch

from plan2scene.camera import Camera
from plan2scene.errors import InputError
from plan2scene.photos.labels import labeller
from plan2scene.photos.labels.network import Attention, SegmentationNet
from plan2scene.photos.labels.palette import DOOR, OTHER, WALL, WINDOW, without_openings
from plan2scene.photos.labels.segmentation import (
    MEDIAN,
    Segmenter,
    brightened,
    confidence_of,
    labels_of,
    load_segmenter,
    network_size,
    upsampled_argmax,
)
from plan2scene.weights import save_model_file

TINY = {"widths": [8, 8, 8, 8, 8], "depths": [1, 1, 1, 1], "decoder": 16, "long_side": 64}


def _tiny() -> SegmentationNet:
    torch.manual_seed(0)
    return SegmentationNet(**TINY).eval()  # type: ignore[arg-type]


def _photo(height: int, width: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 256, (height, width, 3), dtype=np.uint8)


def test_network_gives_four_logits_at_half_resolution() -> None:
    network = _tiny()
    assert network(torch.zeros(2, 3, 64, 96)).shape == (2, 4, 32, 48)


def test_attention_begins_as_nothing_and_then_sees_far_places() -> None:
    torch.manual_seed(0)
    block = Attention(64)
    x = torch.randn(1, 64, 4, 6)
    assert torch.equal(block(x), x)
    torch.nn.init.normal_(block.mix.weight)
    elsewhere = x.clone()
    elsewhere[..., -1, -1] += 3 * torch.randn(64)
    assert (block(elsewhere) - block(x))[..., 0, 0].abs().max() > 1e-3


def test_a_network_that_tells_openings_labels_the_same_without_them() -> None:
    torch.manual_seed(0)
    segmenter = Segmenter(SegmentationNet(**TINY, labels=6))  # type: ignore[arg-type]
    image = _photo(50, 70)
    told = segmenter.labels(image, openings=True)
    assert {DOOR, WINDOW} & set(np.unique(told).tolist())
    assert np.array_equal(without_openings(told), segmenter.labels(image))
    four = Segmenter(_tiny())
    assert np.array_equal(four.labels(image, openings=True), four.labels(image))


def test_what_may_be_a_door_a_window_or_a_thing_is_other() -> None:
    share = np.array([0.2, 0.01, 0.4, 0.01, 0.18, 0.2], np.float32)
    logits = np.tile(np.log(share)[:, None, None], (1, 4, 4))
    assert (labels_of(logits, (8, 8)) == OTHER).all()
    assert np.allclose(confidence_of(logits, (8, 8)), 0.58, atol=1e-3)
    logits[WALL] += 1
    assert (labels_of(logits, (8, 8), openings=True) == WALL).all()


def test_temperature_of_four_labels_changes_confidence_alone() -> None:
    network = _tiny()
    sharp = Segmenter(network).logits(_photo(48, 64), None)
    network.architecture["temperature"] = 2.0
    soft = Segmenter(network).logits(_photo(48, 64), None)
    assert np.allclose(sharp, 2 * soft, atol=1e-6)
    assert (confidence_of(sharp, (48, 64)) > confidence_of(soft, (48, 64))).all()


def test_logits_are_adjusted_by_label_before_the_temperature(tmp_path: Path) -> None:
    network = _tiny()
    plain = Segmenter(network).logits(_photo(48, 64), None)
    adjusted = {**network.architecture, "temperature": 2.0, "logit_adjustment": [0, 0, 0.5, 0]}
    save_model_file(tmp_path / "m.safetensors", network.state_dict(), adjusted, half=False)
    found = load_segmenter(tmp_path / "m.safetensors").logits(_photo(48, 64), None)
    assert np.allclose(2 * found - plain, np.array([0, 0, 0.5, 0])[:, None, None], atol=1e-5)
    save_model_file(
        tmp_path / "m.safetensors", network.state_dict(), {**adjusted, "logit_adjustment": [0.5]}
    )
    with pytest.raises(InputError, match="1 adjustments of 4 labels"):
        load_segmenter(tmp_path / "m.safetensors")


def test_every_weight_of_the_network_gets_a_gradient() -> None:
    network = _tiny().train()
    network(torch.rand(2, 3, 64, 64)).square().mean().backward()
    missing = [n for n, p in network.named_parameters() if p.grad is None]
    assert missing == []


def test_default_network_is_small_enough_to_ship() -> None:
    size = sum(p.numel() for p in SegmentationNet().parameters())
    assert 1_000_000 < size < 5_000_000  # 10 MB as float16


@pytest.mark.parametrize(
    ("size", "expected"),
    [((480, 640), (256, 320)), ((640, 480), (320, 256)), ((10, 1000), (32, 320))],
)
def test_network_size_is_a_multiple_of_the_stride(
    size: tuple[int, int], expected: tuple[int, int]
) -> None:
    assert network_size(size, 320) == expected


def test_upsampled_argmax_keeps_the_border_in_place() -> None:
    logits = np.zeros((4, 4, 4), np.float32)
    logits[1, 2:] = 1.0
    logits[2, :2] = 1.0
    labels = upsampled_argmax(logits, (40, 20))
    assert (labels[:20] == 2).all()
    assert (labels[20:] == 1).all()


def _colours(_: SegmentationNet, x: torch.Tensor, __: torch.Tensor | None) -> torch.Tensor:
    """Return logits that are the colours: red is floor, green wall, blue ceiling."""
    small = x[:, :, ::2, ::2]
    return torch.cat([torch.full_like(small[:, :1], 0.5), small], dim=1)


def test_labels_have_the_size_of_the_photo() -> None:
    labels = Segmenter(_tiny()).labels(_photo(50, 70))
    assert labels.shape == (50, 70)
    assert labels.dtype == np.uint8


def test_mirrored_answers_come_back_where_they_belong(monkeypatch: pytest.MonkeyPatch) -> None:
    network = _tiny()
    monkeypatch.setattr(SegmentationNet, "forward", _colours)
    image = np.zeros((48, 64, 3), np.uint8)
    image[:, :20, 0], image[:, 20:50, 1] = 255, 255
    labels = Segmenter(network).labels(image)
    assert (labels[:, :19] == 1).all() and (labels[:, 22:48] == 2).all()
    assert (labels[:, 52:] == 0).all()


def test_elevation_counts_where_it_is_known() -> None:
    torch.manual_seed(0)
    network = SegmentationNet(**TINY, elevation=True).eval()  # type: ignore[arg-type]
    x, sine = torch.rand(1, 3, 64, 96), torch.rand(1, 64, 96) * 2 - 1
    assert torch.equal(network(x, torch.full_like(sine, torch.nan)), network(x))
    assert not torch.allclose(network(x, sine), network(x))
    assert torch.equal(_tiny()(x, sine), _tiny()(x))  # made without the input


def _camera(up: tuple[float, float, float]) -> Camera:
    """Return a camera of 64 x 48 pixels that has `up` there, level in x or in z."""
    level = (1, 0, 0) if up[0] == 0 else (-up[1], up[0], 0)
    rotation = np.stack([level, up, np.cross(level, up)], 1)
    return Camera(64, 48, 40.0, 31.5, 23.5, tuple(map(tuple, rotation)), "config", 1.0, False)


def test_segmenter_tells_the_network_where_the_horizon_is() -> None:
    """A network that reads the elevation alone labels what is below the horizon floor."""
    network = SegmentationNet(**TINY, elevation=True).eval()  # type: ignore[arg-type]
    seen: list[torch.Tensor] = []
    network.register_forward_pre_hook(lambda _m, args: seen.append(args[1]))
    tilt = np.deg2rad(10)  # looks down: the horizon is above the middle
    Segmenter(network).labels(_photo(48, 64), _camera((0.0, -np.cos(tilt), -np.sin(tilt))))
    elevation = seen[0][0].numpy()
    below = elevation < 0
    horizon = 48 / 2 - 40 * np.tan(tilt)  # rows of the photo
    rows = (np.arange(elevation.shape[0]) + 0.5) / elevation.shape[0] * 48
    assert np.array_equal(below.all(axis=1), rows > horizon)


def test_a_mirrored_photo_has_a_mirrored_horizon() -> None:
    network = SegmentationNet(**TINY, elevation=True).eval()  # type: ignore[arg-type]
    seen: list[torch.Tensor] = []
    network.register_forward_pre_hook(lambda _m, args: seen.append(args[1]))
    Segmenter(network).labels(_photo(48, 64), _camera((0.6, -0.8, 0.0)))
    plain, mirrored = (sines[0].numpy() for sines in seen[:2])  # at the first and second size
    larger = cv2.resize(plain, mirrored.shape[::-1], interpolation=cv2.INTER_LINEAR)
    assert np.allclose(mirrored[:, ::-1], larger, atol=0.05)
    assert not np.allclose(mirrored, larger, atol=0.3)


def test_dim_photos_are_brightened_and_others_are_not() -> None:
    ramp = np.tile(np.arange(256, dtype=np.uint8)[None, :, None], (8, 1, 3))
    dim = (ramp * 0.2).astype(np.uint8)
    assert np.median(brightened(dim)) / 255 == pytest.approx(MEDIAN, abs=0.02)
    assert (np.diff(brightened(dim)[0, :, 0].astype(int)) >= 0).all()
    assert np.array_equal(brightened(ramp), ramp)
    assert np.array_equal(brightened(ramp * 0), ramp * 0)  # nothing to see


def test_weights_file_round_trip(tmp_path: Path) -> None:
    network = _tiny()
    path = tmp_path / "segmentation.safetensors"
    save_model_file(path, network.state_dict(), network.architecture, half=False)
    image = _photo(50, 70)
    loaded = load_segmenter(path)
    assert loaded.network.long_side == 64
    assert np.array_equal(loaded.labels(image), Segmenter(network).labels(image))


def test_weights_of_another_network_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "other.safetensors"
    save_model_file(path, {"x": torch.zeros(1)}, {"long_side": 64})
    with pytest.raises(InputError, match="segmentation network"):
        load_segmenter(path)
    save_model_file(path, {"x": torch.zeros(1)}, {"layers": 3})
    with pytest.raises(InputError, match=r"other\.safetensors"):
        load_segmenter(path)


def test_reading_masks_does_not_import_torch() -> None:
    code = "import sys, plan2scene.photos.masks; sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize(
    ("drafts", "fallback", "seen"),
    [(True, False, True), (True, True, False), (False, False, False)],
)
def test_labels_are_made_with_the_camera_that_a_draft_gives(
    monkeypatch: pytest.MonkeyPatch, drafts: bool, fallback: bool, seen: bool
) -> None:
    rows = ((-1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0))
    camera = Camera(64, 48, 40.0, 31.5, 23.5, rows, "config", 1.0, fallback)
    drafted = np.full((48, 64), WALL, np.uint8)

    def estimate(_image: np.ndarray, labels: np.ndarray, **_: object) -> Camera:
        assert labels is drafted
        return camera

    monkeypatch.setattr(labeller, "estimate_camera", estimate)
    told: list[Camera | None] = []

    def label(_photo: str, image: np.ndarray, given: Camera | None) -> labeller.Labelled:
        told.append(given)
        return labeller.Labelled(np.zeros(image.shape[:2], np.uint8))

    draft = (lambda _image: drafted) if drafts else None
    labeller.Labeller(label, draft).labelled("a.jpg", _photo(48, 64))
    assert told == [camera if seen else None]
