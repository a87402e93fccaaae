import numpy as np
import pytest
import torch

from plan2scene.checkpoints.convert import convert_checkpoint
from plan2scene.errors import InputError
from plan2scene.metrics.inception import InceptionV3
from plan2scene.metrics.networks import features_of, load_network, network_name, substances_of
from plan2scene.metrics.vgg import VggClassifier
from plan2scene.weights import MODELS, save_model_file


def _images(count, size=128):
    rng = np.random.default_rng(2)
    levels = rng.integers(20, 200, (count, 1, 1, 3))
    return list((levels + rng.integers(0, 50, (count, size, size, 3))).astype(np.uint8))


@pytest.fixture(scope="module")
def inception_state():
    with torch.device("meta"):
        rng = np.random.default_rng(0)
        state = {}
        for name, value in sorted(InceptionV3().state_dict().items()):
            if name.endswith("num_batches_tracked"):
                continue
            noise = rng.standard_normal(tuple(value.shape), dtype=np.float32)
            if value.ndim == 4:
                noise *= np.sqrt(2 / np.prod(value.shape[1:]))
            elif name.endswith("running_var"):
                noise = 1 + 0.1 * np.abs(noise)
            elif name.endswith("bn.weight"):
                noise = 1 + 0.1 * noise
            else:
                noise *= 0.1
            state[name] = torch.from_numpy(np.asarray(noise, np.float32))
        return state


# What torch-fidelity 0.4.0 ("inception-v3-compat") and torchvision 0.28.0 (at 299 pixels, 2 RGB
# - 1) return for these weights and this image: the first features, their mean and deviation.
REFERENCE = {
    1008: ([0.0, 1.3473264, 0.020952649, 0.0054326775, 0.00041591728], 0.22175102, 0.29531658),
    1000: ([0.0, 1.3407766, 0.01722002, 0.01037556, 0.001741], 0.20544219, 0.26652187),
}


@pytest.mark.parametrize("classes", [1008, 1000])
def test_inception_is_the_network_of_the_reference(inception_state, classes, tmp_path):
    y, x = np.mgrid[:128, :128]
    image = np.stack([(2 * x) % 256, (3 * y + x) % 256, (x * y // 8) % 256], -1).astype(np.uint8)
    extra = {"fc.weight": torch.zeros(classes, 2048), "fc.bias": torch.zeros(classes)}
    extra |= {"Mixed_5b.branch1x1.bn.num_batches_tracked": torch.tensor(0)}
    extra |= {"AuxLogits.conv0.conv.weight": torch.zeros(1)} if classes == 1000 else {}
    torch.save(inception_state | extra, tmp_path / "given.pth")
    convert_checkpoint("inception", tmp_path / "given.pth", tmp_path / "w.safetensors")
    assert network_name(tmp_path / "w.safetensors") == "inception"
    (features,) = features_of(tmp_path / "w.safetensors", [image])
    first, mean, deviation = REFERENCE[classes]
    assert features.shape == (2048,) and np.allclose(features[:5], first, atol=1e-5)
    assert features.mean() == pytest.approx(mean, abs=1e-5)
    assert features.std() == pytest.approx(deviation, abs=1e-5)


def test_inception_checkpoints_of_another_form_are_refused(tmp_path):
    torch.save({"fc.bias": torch.zeros(10)}, tmp_path / "ten.pth")
    with pytest.raises(InputError, match=r"fc\.bias of 1008 or 1000 classes, found 10"):
        convert_checkpoint("inception", tmp_path / "ten.pth", tmp_path / "o")
    torch.save({"fc.bias": torch.zeros(1008)}, tmp_path / "bare.pth")
    with pytest.raises(InputError, match=r"expected tensor .*tensors missing"):
        convert_checkpoint("inception", tmp_path / "bare.pth", tmp_path / "o")
    with pytest.raises(InputError, match="weights of network inception"):
        load_network(MODELS / "features.safetensors", "inception")


def test_vgg_tells_substances(tmp_path):
    torch.manual_seed(3)
    net = VggClassifier(divisor=32).eval()
    with torch.no_grad():  # the classes of random weights would all be one
        for layer in net.modules():
            if isinstance(layer, torch.nn.Conv2d | torch.nn.Linear):
                torch.nn.init.kaiming_normal_(layer.weight)
        rgb = torch.from_numpy(np.stack(_images(11))).permute(0, 3, 1, 2).float()
        net.classifier[-1].bias -= net(rgb).mean(dim=0)
    path, architecture = tmp_path / "v.safetensors", {"network": "vgg16", "divisor": 32}
    save_model_file(path, net.state_dict(), architecture, half=False)
    images = _images(11)
    with torch.no_grad():
        expected = net(torch.from_numpy(np.stack(images)).permute(0, 3, 1, 2).float()).argmax(dim=1)
    found = substances_of(path, images)
    assert found.dtype == np.int64 and np.array_equal(found, expected)
    assert len(set(found.tolist())) > 1 and substances_of(path, []).shape == (0,)
