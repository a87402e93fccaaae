"""The segmentation network: several as one, and folded for labelling."""

from __future__ import annotations

import copy
from pathlib import Path

import numpy as np
import pytest
import torch
from torch import nn

from plan2scene.errors import InputError
from plan2scene.photos.labels.network import (
    MOST_MEMBERS,
    Ensemble,
    SegmentationNet,
    ensemble_of,
    folded,
)
from plan2scene.photos.labels.segmentation import SCALES, Segmenter, load_segmenter
from plan2scene.weights import save_model_file

TINY = {"widths": [8] * 5, "depths": [1] * 4, "decoder": 16, "long_side": 64, "elevation": True}


def _network(seed: int) -> SegmentationNet:
    torch.manual_seed(seed)
    return SegmentationNet(**TINY).eval()  # type: ignore[arg-type]


def _photo() -> np.ndarray:
    return np.random.default_rng(0).integers(0, 256, (48, 64, 3), dtype=np.uint8)


def test_logits_are_the_members_mean() -> None:
    networks = [_network(seed) for seed in range(3)]
    ensemble = ensemble_of(networks).eval()
    x, elevation = torch.rand(2, 3, 64, 96), torch.rand(2, 64, 96)
    mean = sum(network(x, elevation) for network in networks) / 3
    torch.testing.assert_close(ensemble(x, elevation), mean)


def test_each_network_sees_a_photo_mirrored_at_the_sizes_where_its_neighbour_does_not() -> None:
    networks, image = [_network(seed) for seed in range(2)], _photo()
    found = Segmenter(ensemble_of(networks)).logits(image, None)
    backward = np.ascontiguousarray(image[:, ::-1])
    here = [Segmenter(network).logits(image, None) for network in networks]
    there = [Segmenter(network).logits(backward, None)[..., ::-1] for network in networks]
    assert not np.allclose(here[1], there[1], atol=1e-3)
    assert np.allclose(found, (here[0] + there[1]) / 2, atol=1e-5)


def test_a_draft_is_the_first_members_labels() -> None:
    networks = [_network(seed) for seed in range(2)]
    for label, network in enumerate(networks):
        network.head.bias.data[label] += 10.0  # type: ignore[union-attr,index]
    draft = Segmenter(ensemble_of(networks)).draft(_photo())
    assert draft.shape == _photo().shape[:2] and (draft == 0).all()
    assert (Segmenter(networks[1]).draft(_photo()) == 1).all()


def test_a_draft_is_made_by_one_network_at_one_size(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[torch.Size] = []
    forward = SegmentationNet.forward

    def counted(
        self: SegmentationNet, x: torch.Tensor, elevation: torch.Tensor | None = None
    ) -> torch.Tensor:
        seen.append(x.shape)
        return forward(self, x, elevation)

    monkeypatch.setattr(SegmentationNet, "forward", counted)
    segmenter = Segmenter(ensemble_of([_network(seed) for seed in range(2)]))
    segmenter.draft(_photo())
    assert len(seen) == 1
    segmenter.labels(_photo())
    assert len(seen) == 1 + 2 * len(SCALES)
    assert seen[0] == seen[3]


def test_a_file_of_several_networks_round_trips(tmp_path: Path) -> None:
    ensemble = ensemble_of([_network(seed) for seed in range(2)])
    path = tmp_path / "e.safetensors"
    save_model_file(path, ensemble.state_dict(), ensemble.architecture, half=False)
    loaded = load_segmenter(path)
    assert isinstance(loaded.network, Ensemble) and len(loaded.network.members) == 2
    assert loaded.network.elevation and loaded.network.long_side == 64
    assert np.array_equal(loaded.labels(_photo()), Segmenter(ensemble).labels(_photo()))


@pytest.mark.parametrize("members", [0, MOST_MEMBERS + 1, "two"])
def test_a_file_of_no_or_too_many_networks_is_refused(tmp_path: Path, members: object) -> None:
    ensemble = ensemble_of([_network(0)])
    path = tmp_path / "e.safetensors"
    save_model_file(path, ensemble.state_dict(), {**ensemble.architecture, "members": members})
    with pytest.raises(InputError, match=r"weights of the segmentation network"):
        load_segmenter(path)


def test_networks_of_other_shapes_make_no_ensemble() -> None:
    wide = SegmentationNet(**{**TINY, "decoder": 32})  # type: ignore[arg-type]
    with pytest.raises(RuntimeError, match="size mismatch"):
        ensemble_of([_network(0), wide])


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
