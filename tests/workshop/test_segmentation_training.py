import dataclasses

import numpy as np
import pytest
import torch
from PIL import Image

from plan2scene.errors import InputError
from plan2scene.images import write_png
from plan2scene.io import write_json
from plan2scene.photos.labels.network import Ensemble, ImagenetSegmentationNet, SegmentationNet
from plan2scene.photos.labels.palette import (
    CEILING,
    DOOR,
    FLOOR,
    LABELS_AND_OPENINGS,
    OTHER,
    WALL,
    WINDOW,
    write_label_png,
)
from plan2scene.photos.labels.segmentation import load_segmenter
from plan2scene.weights import save_model_file
from plan2scene_workshop.segmentation import run as runs
from plan2scene_workshop.segmentation.data import (
    LabelledPhoto,
    confusion,
    read_labelled_photos,
    scores,
)
from plan2scene_workshop.segmentation.settings import SegmentationSettings
from plan2scene_workshop.segmentation.training import train_network

SHORT = SegmentationSettings(steps=1, batch=2, small=32, long_side=32)


def _striped(seed=0, size=(48, 64)):
    rng = np.random.default_rng(seed)
    labels = np.full(size, WALL, np.uint8)
    labels[: int(rng.integers(8, 16))] = CEILING
    labels[-int(rng.integers(8, 16)) :] = FLOOR
    left = int(rng.integers(0, 40))
    labels[20:40, left : left + 16] = OTHER
    colours = np.array([[200, 40, 40], [40, 160, 60], [60, 80, 190], [240, 240, 200]])
    noise = rng.normal(0, 6, (*size, 3))
    return LabelledPhoto(f"p{seed}", np.clip(colours[labels] + noise, 0, 255).astype("u1"), labels)


def test_scores_take_doors_and_windows_as_other_and_by_themselves():
    true = np.array([[DOOR, WINDOW, OTHER, WALL]], np.uint8)
    found = scores([confusion(np.array([[WINDOW, OTHER, OTHER, DOOR]], np.uint8), true)])
    assert found.iou[OTHER] == pytest.approx(3 / 4) and found.iou[WALL] == 0
    assert found.accuracy == pytest.approx(3 / 4) and found.openings == pytest.approx(1 / 3)


def _tiny():
    torch.manual_seed(0)
    return SegmentationNet(widths=[8, 8, 8, 8, 8], depths=[1, 1, 1, 1], decoder=16, long_side=64)


def test_training_learns_what_colours_tell():
    sizes = dict(batch=4, small=64, long_side=64)
    settings = SegmentationSettings(**sizes, steps=30, learning_rate=1e-2, evaluate_every=15)
    photos = [_striped(k) for k in range(12)]
    held_out = [_striped(k) for k in range(100, 104)]
    trained = train_network(_tiny(), photos, held_out, settings, seed=0)
    assert trained.step in (15, 30)
    assert trained.score > 0.4  # the commonest label alone gives under 0.15


def test_a_network_learns_its_teachers_averaged_answers_whatever_labels_say(tmp_path):
    torch.manual_seed(0)
    photos = [_striped(k) for k in range(6)]
    files = []
    for label in (CEILING, OTHER):  # each sees its own label everywhere, the first more surely
        network = _tiny()
        torch.nn.init.zeros_(network.head.weight)
        torch.nn.init.zeros_(network.head.bias)
        with torch.no_grad():
            network.head.bias[label] = 8.0 if label == CEILING else 4.0
        files.append(tmp_path / f"{label}.safetensors")
        save_model_file(files[-1], network.state_dict(), network.architecture)
    settings = dataclasses.replace(SHORT, steps=40, learning_rate=5e-2, evaluate_every=0)
    taught = dict(teachers=":".join(map(str, files)), distillation=1.0, ema_decay=0.5)
    settings = dataclasses.replace(settings, **taught)
    trained = train_network(_tiny(), photos, photos[:1], settings, seed=0).network
    found = trained(torch.rand(1, 3, 64, 64)).softmax(dim=1).mean(dim=(0, 2, 3))
    wanted = torch.tensor([2.0, 0, 0, 4.0]).softmax(dim=0)
    torch.testing.assert_close(found, wanted, atol=0.06, rtol=0)


def _write_data_set(root):
    (root / "data_lists").mkdir(parents=True)
    for split, house in (("train", "h1"), ("val", "h2")):
        (root / "data_lists" / f"{split}.txt").write_text(house + "\n")
        truth = root / "truth" / split / house
        photo = _striped(1 if split == "train" else 2)
        name = f"{house}_a.png"
        write_json(truth / "cameras.json", {name: {}})
        write_png(root / "photos" / name, photo.image)
        write_label_png(truth / "masks" / f"{house}_a.png", photo.labels)


def test_a_trained_network_is_written_with_those_beside_it_and_goes_on_from_their_mean(tmp_path):
    _write_data_set(tmp_path / "data")
    other = SegmentationNet(attention=2, elevation=True, labels=len(LABELS_AND_OPENINGS))
    other_file, model = tmp_path / "o.safetensors", tmp_path / "m.safetensors"
    save_model_file(other_file, other.state_dict(), other.architecture)
    settings = dataclasses.replace(SHORT, temperature=1.0, beside=str(other_file))
    card = tmp_path / "m.md"
    measured = runs.train_segmentation(tmp_path / "data", model, card, settings=settings, seed=0)
    text = card.read_text()
    assert "o.safetensors" in text and f"| **mean** | {measured.mean_iou:.3f} |" in text
    assert "1 rendered photos" in text and "Seed 0; settings: " in text and "`batch` 2" in text
    assert load_segmenter(model).labels(_striped(2).image).shape == (48, 64)
    found = load_segmenter(model).network
    assert isinstance(found, Ensemble)
    heads = [member.state_dict()["head.weight"] for member in found.members]
    torch.testing.assert_close(heads[1], other.head.weight.half().float())
    runs.start_from(other, model)
    torch.testing.assert_close(other.head.weight.data, sum(heads) / 2)
    tiny = _tiny()
    save_model_file(other_file, tiny.state_dict(), tiny.architecture)
    with pytest.raises(InputError, match="shapes"):
        runs.train_segmentation(tmp_path / "data", model, card, settings=settings, seed=0)


def test_a_network_of_imagenet_adds_to_one_of_the_ensemble_that_training_starts_from(
    tmp_path, colours_as_imagenet
):
    _write_data_set(tmp_path / "data")
    networks = [SegmentationNet(elevation=True, labels=len(LABELS_AND_OPENINGS)) for _ in range(2)]
    ensemble = runs.ensemble_of(networks)
    start, model = tmp_path / "s.safetensors", tmp_path / "m.safetensors"
    save_model_file(start, ensemble.state_dict(), ensemble.architecture)
    settings = dataclasses.replace(SHORT, temperature=1.0, imagenet=True, member=1)
    data, card = tmp_path / "data", tmp_path / "m.md"
    with pytest.raises(InputError, match="an ensemble, found null"):
        runs.train_segmentation(data, model, card, settings=settings, seed=0)
    settings = dataclasses.replace(settings, start=str(start), fresh_learning_rate=1.0)
    runs.train_segmentation(data, model, card, settings=settings, seed=0)
    found = load_segmenter(model).network
    assert isinstance(found, ImagenetSegmentationNet)
    own = networks[1].half().float().state_dict()
    assert all(torch.equal(v, own[k]) for k, v in found.state_dict().items() if "stage" in k)
    added = list(found.adapters[4].children())[-1]
    assert added.bias.abs().max() > 0.5
    again = dataclasses.replace(settings, start=str(model), fresh_learning_rate=0.0)
    runs.train_segmentation(data, start, card, settings=again, seed=1)
    bias = list(load_segmenter(start).network.adapters[4].children())[-1].bias
    assert torch.allclose(bias, added.bias, atol=0.1)


def test_normals_depth_and_openings_are_read_where_there_are_some(tmp_path):
    _write_data_set(tmp_path)
    plain = read_labelled_photos(tmp_path, "train", long_side=64)[0]
    assert plain.geometry is None and not plain.openings
    truth = tmp_path / "truth" / "train" / "h1"
    normals = np.zeros((48, 64, 3), np.uint8)
    normals[:24] = (255, 128, 128)
    for folder, values in (("normals", normals), ("depth", np.full((48, 64), 2500, np.uint16))):
        (truth / folder).mkdir()
        Image.fromarray(values).save(truth / folder / "h1_a.png")
    write_label_png(truth / "masks" / "h1_a.png", np.full((48, 64), WINDOW, np.uint8))
    photo = read_labelled_photos(tmp_path, "train", long_side=64)[0]
    assert photo.openings and (photo.labels == WINDOW).all()
    assert photo.geometry is not None and photo.geometry.shape == (24, 32, 4)
    assert np.allclose(photo.geometry[0, 0], (1, 0, 0, 2.5), atol=0.01)
    assert photo.geometry[-1, 0].tolist() == [0, 0, 0, 2.5]


def test_amodal_labels_are_learned_where_there_are_some(tmp_path):
    _write_data_set(tmp_path)
    visible = read_labelled_photos(tmp_path, "train", long_side=32)[0]
    assert visible.learned is visible.labels
    settings = SegmentationSettings(amodal=True)
    model, card = tmp_path / "m.safetensors", tmp_path / "m.md"
    with pytest.raises(InputError, match="amodal labels"):
        runs.train_segmentation(tmp_path, model, card, settings=settings, seed=1)
    behind = tmp_path / "truth" / "train" / "h1" / "amodal" / "h1_a.png"
    write_label_png(behind, np.full((48, 64), WINDOW, np.uint8))
    photo = read_labelled_photos(tmp_path, "train", long_side=32)[0]
    np.testing.assert_array_equal(photo.labels, visible.labels)
    np.testing.assert_array_equal(photo.learned, np.full((24, 32), WINDOW))
