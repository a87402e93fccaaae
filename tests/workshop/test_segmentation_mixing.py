from __future__ import annotations

import torch

from plan2scene.photos.labels.network import SegmentationNet
from plan2scene_workshop.segmentation.mixing import mix_statistics, mixed


def _network() -> SegmentationNet:
    torch.manual_seed(0)
    return SegmentationNet(widths=[8] * 5, depths=[1] * 4, decoder=16, long_side=64)


def test_statistics_lie_between_those_of_two_views_and_shapes_stay() -> None:
    torch.manual_seed(1)
    features = torch.randn(2, 3, 40, 40) * torch.tensor([1.0, 4.0]).view(2, 1, 1, 1)
    features[1] += 10
    found = mixed(features)
    mean, true = found.mean(dim=(2, 3)), features.mean(dim=(2, 3))
    assert bool(((mean >= true[0] - 1e-3) & (mean <= true[1] + 1e-3)).all())
    deviation, own = found.std(dim=(2, 3)), features.std(dim=(2, 3))
    assert bool(((deviation >= own[0] - 1e-3) & (deviation <= own[1] + 1e-3)).all())

    def plain(x: torch.Tensor) -> torch.Tensor:
        return (x - x.mean(dim=(2, 3), keepdim=True)) / x.std(dim=(2, 3), keepdim=True)

    torch.testing.assert_close(plain(found), plain(features), atol=1e-4, rtol=1e-4)


def test_equal_views_stay_as_they_are() -> None:
    view = torch.rand(1, 4, 16, 16)
    both = torch.cat([view, view])
    torch.testing.assert_close(mixed(both), both, atol=1e-5, rtol=1e-5)
    assert mixed(both.bfloat16()).dtype == torch.bfloat16


def test_features_are_mixed_in_training_alone_and_until_it_is_ended() -> None:
    network, views = _network(), torch.rand(4, 3, 64, 64)
    plain = network.eval()(views)
    handles = mix_statistics(network, 1.0)
    torch.testing.assert_close(network(views), plain)  # in evaluation mode nothing is mixed
    norms = [m for m in network.modules() if isinstance(m, torch.nn.BatchNorm2d)]
    network.train()
    for norm in norms:
        norm.eval()  # so that mixing alone can make a difference
    torch.manual_seed(2)
    assert not torch.allclose(network(views), plain, atol=1e-3)
    for handle in handles:
        handle.remove()
    torch.testing.assert_close(network(views), plain)


def test_a_chance_of_none_mixes_nothing() -> None:
    network, views = _network().train(), torch.rand(2, 3, 64, 64)
    plain = network(views)
    mix_statistics(network, 0.0)
    torch.testing.assert_close(network(views), plain)
