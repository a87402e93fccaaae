import numpy as np
import torch
from torch import nn

from plan2scene.photos.labels.network import SegmentationNet, folded
from plan2scene_workshop.segmentation.run import ensemble_of

TINY = {"widths": [8] * 5, "depths": [1] * 4, "decoder": 16, "long_side": 64, "elevation": True}


def _network(seed):
    torch.manual_seed(seed)
    return SegmentationNet(**TINY).eval()


def _photo():
    return np.random.default_rng(0).integers(0, 256, (48, 64, 3), dtype=np.uint8)


def test_logits_are_the_members_mean():
    networks = [_network(seed) for seed in range(3)]
    ensemble = ensemble_of(networks).eval()
    x, elevation = torch.rand(2, 3, 64, 96), torch.rand(2, 64, 96)
    mean = sum(network(x, elevation) for network in networks) / 3
    torch.testing.assert_close(ensemble(x, elevation), mean)


def test_a_folded_network_has_no_batch_norm_and_the_same_answers():
    torch.manual_seed(0)
    network = SegmentationNet(widths=[8] * 5, depths=[2] * 4, decoder=16, elevation=True)
    for module in network.modules():
        if isinstance(module, nn.BatchNorm2d):
            nn.init.normal_(module.weight, 1, 0.3)
            nn.init.normal_(module.bias, 0, 0.3)
    network.train()
    for _ in range(3):
        network(torch.rand(4, 3, 64, 96))
    quick = folded(network)
    assert not [m for m in quick.modules() if isinstance(m, nn.BatchNorm2d)]
    assert not quick.training and not any(p.requires_grad for p in quick.parameters())
    x, elevation = torch.rand(2, 3, 64, 96), torch.rand(2, 64, 96) - 0.5
    torch.testing.assert_close(quick(x, elevation), network.eval()(x, elevation), atol=1e-4, rtol=0)
