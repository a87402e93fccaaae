"""Losses of the texture model's training are the metrics, with gradients."""

import numpy as np
import pytest
import torch

from plan2scene.metrics.color_freq_tile import color_distance, freq_distance, periodic_component
from plan2scene_workshop.texture import losses


def test_frequency_distance_is_freq_and_has_gradients() -> None:
    rng = np.random.default_rng(1)
    images = rng.integers(0, 256, (2, 128, 128, 3), dtype=np.uint8)
    images[1] = np.cumsum(images[1].astype(float), axis=0).astype(np.uint8) // 2
    tile = np.rint(periodic_component(images[0].mean(2)))[..., None].clip(0, 255).astype(np.uint8)
    tile = np.repeat(tile, 3, axis=2)
    mine, theirs = (torch.from_numpy(i[None]).permute(0, 3, 1, 2) / 255 for i in (tile, images[1]))
    mine.requires_grad_()
    found = losses.frequency_distance(mine, theirs)
    assert found.item() == pytest.approx(freq_distance(tile, images[1]), rel=0.05)
    found.sum().backward()
    assert mine.grad is not None and bool(torch.isfinite(mine.grad).all())


def test_histogram_distance_is_nearly_color_and_has_gradients() -> None:
    rng = np.random.default_rng(0)
    images = rng.integers(0, 256, (2, 1, 64, 64, 3), dtype=np.uint8)
    images[1] = np.clip(images[1] * 0.6, 0, 255).astype(np.uint8)
    mine, theirs = (torch.from_numpy(i).permute(0, 3, 1, 2).float() / 255 for i in images)
    found = losses.histogram_distance(mine, theirs)
    assert float(found) == pytest.approx(color_distance(images[0, 0], images[1, 0]), abs=0.02)
    grey = torch.full((1, 3, 64, 64), 0.5).requires_grad_()
    losses.histogram_distance(grey, theirs).sum().backward()
    assert grey.grad is not None and bool(torch.isfinite(grey.grad).all())
