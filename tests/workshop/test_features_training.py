import numpy as np

from plan2scene.materials import random_material
from plan2scene.metrics.networks import describe_images
from plan2scene.metrics.substance_network import load_substance_network
from plan2scene_workshop.features.training import FeaturesSettings, train_features
from plan2scene_workshop.texture.data import MaterialSettings, write_materials

TINY = FeaturesSettings(steps=3, batch=4, held_out_crops=16)


def test_training_writes_weights_and_card_and_repeats_itself(tmp_path):
    materials = tmp_path / "materials.npz"
    write_materials(materials, MaterialSettings(procedural=8, held_out=4), seed=0)
    files = [(tmp_path / f"{k}.safetensors", tmp_path / f"{k}.md") for k in "ab"]
    results = [train_features(materials, *pair, settings=TINY, seed=0) for pair in files]
    assert results[0] == results[1]
    assert files[0][0].read_bytes() == files[1][0].read_bytes()
    card = (tmp_path / "a.md").read_text()
    for name, accuracy in results[0].items():
        assert f"| {name} | 16 | {accuracy:.3f} |" in card
    network = load_substance_network(tmp_path / "a.safetensors")
    features, _ = describe_images(network, [random_material("tile", 1, size_px=128).albedo])
    assert features.shape == (1, 64) and np.isfinite(features).all()
