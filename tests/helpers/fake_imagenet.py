"""What stands for the network of ImageNet, whose weights an extra brings."""

import pytest
import torch
from torch.nn import functional

from plan2scene.photos.labels import network
from plan2scene.photos.labels.imagenet import BLOCKS


@pytest.fixture
def colours_as_imagenet(monkeypatch):

    def maps(_network, x):
        grey = (functional.avg_pool2d(x, 2**k).mean(1, keepdim=True) for k in range(1, 6))
        return [y.expand(-1, n, -1, -1) for y, n in zip(grey, BLOCKS.values(), strict=True)]

    monkeypatch.setattr(network, "load_imagenet", lambda: torch.nn.Linear(1, 1))
    monkeypatch.setattr(network, "imagenet_maps", maps)
