import numpy as np
import pytest
import torch

from plan2scene.errors import InputError
from plan2scene.photos.labels import imagenet
from plan2scene.photos.labels.labeller import labeller
from plan2scene.photos.labels.network import ImagenetSegmentationNet, SegmentationNet
from plan2scene.photos.labels.segmentation import Segmenter, load_segmenter
from plan2scene.photos.labels.things import ThingKinds
from plan2scene.weights import save_model_file
from plan2scene_workshop.segmentation.run import ensemble_of

TINY = {"widths": [8] * 5, "depths": [1] * 4, "decoder": 16, "long_side": 64, "labels": 6}
X = torch.rand(2, 3, 64, 96)


def _pair(seed=0):
    torch.manual_seed(seed)
    plain, more = SegmentationNet(**TINY), ImagenetSegmentationNet(**TINY)
    more.load_state_dict(plain.state_dict(), strict=False)
    return plain.eval(), more.eval()


def test_it_begins_with_the_answers_of_the_network_that_it_goes_on_from(colours_as_imagenet):
    plain, more = _pair()
    torch.testing.assert_close(more(X), plain(X))


def test_a_file_holds_no_weights_of_imagenet_and_the_labeller_takes_it_beside_its_own(
    colours_as_imagenet, tmp_path
):
    (first, _), (second, more) = _pair(0), _pair(1)
    with torch.no_grad():
        for adapter in more.adapters:
            adapter[-1].bias.normal_()
    added_names = more.state_dict().keys() - second.state_dict().keys()
    assert all(name.startswith("adapters.") for name in added_names)
    own, added = tmp_path / "own.safetensors", tmp_path / "added.safetensors"
    ensemble = ensemble_of([first, second])
    save_model_file(own, ensemble.state_dict(), ensemble.architecture, half=False)
    save_model_file(added, more.state_dict(), more.architecture, half=False)
    assert isinstance(load_segmenter(added).network, ImagenetSegmentationNet)
    image = np.random.default_rng(0).integers(0, 256, (48, 64, 3), dtype=np.uint8)
    found = labeller("imagenet", model=own, imagenet=added).label("a", image, None)
    alone = labeller("embedded", model=own).label("a", image, None)
    assert np.array_equal(found.labels, Segmenter(ensemble, more).labels(image))
    assert not np.allclose(found.probabilities, alone.probabilities, atol=0.01)


def test_without_the_extra_one_line_names_it(monkeypatch):
    monkeypatch.setattr(imagenet, "find_spec", lambda _name: None)
    assert not imagenet.imagenet_installed()
    with pytest.raises(InputError, match="install the extra 'rooms'"):
        imagenet.load_imagenet()


def test_the_network_of_the_extra_sees_nothing_in_a_grey_picture(monkeypatch):
    pytest.importorskip(imagenet.NETWORK)
    pytest.importorskip(imagenet.WEIGHTS)
    grey = np.full((240, 320, 3), 128, np.uint8)
    loaded = imagenet.load_imagenet()
    assert ThingKinds(loaded).probabilities(grey).max() < 0.5
    sizes = [tuple(y.shape) for y in imagenet.imagenet_maps(loaded, X)]
    wanted = zip(imagenet.BLOCKS.values(), range(1, 6), strict=True)
    assert sizes == [(2, channels, 64 >> k, 96 >> k) for channels, k in wanted]
    monkeypatch.setattr(imagenet, "SHA256", "0" * 64)
    with pytest.raises(InputError, match=r"expected weights of SHA-256 0{64}, found 5793"):
        imagenet.load_imagenet()
