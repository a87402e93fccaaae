import cv2
import numpy as np
import torch

from plan2scene.house import SUBSTANCES
from plan2scene.materials import random_material
from plan2scene.metrics.networks import describe_images
from plan2scene.metrics.substance_network import SubstanceNetwork, load_substance_network
from plan2scene.weights import MODELS, save_model_file


def test_a_file_gives_the_same_network_back(tmp_path):
    torch.manual_seed(0)
    network = SubstanceNetwork((4, 6, 8), feature_dim=5)
    for module in network.modules():  # statistics unlike the initial 0 and 1
        if isinstance(module, torch.nn.BatchNorm2d):
            module.running_mean.normal_()
            module.running_var.uniform_(0.5, 2.0)
    network.shift.normal_()
    network.scale.uniform_(0.5, 2.0)
    network = network.eval()
    save_model_file(tmp_path / "f.safetensors", network.state_dict(), network.architecture)
    images = np.random.default_rng(1).integers(0, 256, (18, 128, 128, 3), dtype=np.uint8)
    loaded = load_substance_network(tmp_path / "f.safetensors")
    features, classes = describe_images(loaded, list(images))
    for value in network.state_dict().values():  # weights are stored as float16
        if value.is_floating_point():
            value.copy_(value.half().float())
    with torch.inference_mode():
        expected, logits = network(torch.from_numpy(images).permute(0, 3, 1, 2) / 255)
    assert features.shape == (18, 5) and np.allclose(features, expected.numpy(), atol=1e-5)
    assert np.array_equal(classes, logits.argmax(dim=1).numpy())


def test_embedded_weights_tell_substances_of_unseen_materials():
    images, truth = [], []
    for index, substance in enumerate(SUBSTANCES):
        for seed in range(900, 912):  # windows of half the tile, as crops are
            tile = random_material(substance, seed).albedo
            images.append(cv2.resize(tile[:180, :180], (128, 128), interpolation=cv2.INTER_AREA))
            truth.append(index)
    _, classes = describe_images(load_substance_network(MODELS / "features.safetensors"), images)
    assert np.mean(classes == np.array(truth)) >= 0.7  # the card says 0.83 of such windows
