from __future__ import annotations

import copy

import torch
from torch import nn

from plan2scene.photos.labels.network import SegmentationNet, folded


def _trained() -> SegmentationNet:
    """Return a network whose batch norms have statistics, scales and shifts of their own."""
    torch.manual_seed(0)
    network = SegmentationNet(widths=[8] * 5, depths=[2] * 4, decoder=16, elevation=True)
    for module in network.modules():
        if isinstance(module, nn.BatchNorm2d):
            nn.init.normal_(module.weight, 1, 0.3)
            nn.init.normal_(module.bias, 0, 0.3)
    network.train()
    for _ in range(3):
        network(torch.rand(4, 3, 64, 96))
    return network


def test_a_folded_network_has_no_batch_norm_and_the_same_answers() -> None:
    network = _trained()
    quick = folded(network)
    assert not [m for m in quick.modules() if isinstance(m, nn.BatchNorm2d)]
    assert not quick.training and not any(p.requires_grad for p in quick.parameters())
    x, elevation = torch.rand(2, 3, 64, 96), torch.rand(2, 64, 96) - 0.5
    torch.testing.assert_close(quick(x, elevation), network.eval()(x, elevation), atol=1e-4, rtol=0)


def test_folding_leaves_the_network_as_it_was() -> None:
    network = _trained()
    before = copy.deepcopy(network.state_dict())
    quick = folded(network)
    for parameter in quick.parameters():
        parameter.data.zero_()
    assert network.training
    for name, value in network.state_dict().items():
        assert torch.equal(value, before[name]), name


def test_a_norm_that_follows_no_convolution_stays() -> None:
    kept = folded(nn.Sequential(nn.Conv2d(2, 2, 1), nn.ReLU(), nn.BatchNorm2d(2)))
    assert isinstance(kept[2], nn.BatchNorm2d)
