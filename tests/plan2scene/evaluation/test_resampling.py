"""Further images of decoded textures, and what FID and KID make of them."""

import numpy as np
import pandas as pd
import pytest
import torch

from plan2scene.evaluation.distances import feature_distances
from plan2scene.evaluation.measure import measure_house, read_references
from plan2scene.evaluation.resampling import FurtherSeeds, further_images
from plan2scene.house import SurfaceKey
from plan2scene.images import png_bytes, write_png
from plan2scene.io import read_parquet, write_json, write_parquet
from plan2scene.metrics.feature_sets import frechet_distance, kernel_distance
from plan2scene.metrics.networks import features_of
from plan2scene.textures.model.network import Architecture, TextureModel, architecture_header
from plan2scene.textures.model.synthesis import synthesise_surfaces
from plan2scene.textures.seams import make_seamless
from plan2scene.weights import MODELS, save_model_file

KEYS = [SurfaceKey("r1", "floor"), SurfaceKey("r1", "wall"), SurfaceKey("r2", "floor")]


@pytest.fixture
def seeds(tmp_path):
    rng = np.random.default_rng(1)
    rows = [
        {
            "room_id": key.room_id,
            "surface": key.surface,
            "embedding": np.r_[rng.normal(size=8), rng.uniform(size=3)].astype(np.float32),
        }
        for key in KEYS
    ]
    write_parquet(tmp_path / "propagated.parquet", pd.DataFrame(rows), {"house": "h"})
    torch.manual_seed(0)
    model = TextureModel(Architecture(width=4, substances=4, periodic=False))
    with torch.no_grad():  # random weights show next to no texture
        for name, weight in model.decoder.named_parameters():
            weight.mul_(4.0 if name.endswith("weight") else 1.0)
    save_model_file(tmp_path / "synth", model.state_dict(), architecture_header(model))
    return FurtherSeeds(
        tmp_path / "propagated.parquet",
        tmp_path / "synth",
        count=4,
        seed=7,
        size_px=128,
        seam_correction=False,
    )


def test_images_of_a_surface_differ_in_their_noise_only(seeds):
    images = further_images(seeds, [KEYS[2], KEYS[0]], method="synth", house="h")
    assert len(images) == 2 * 3
    first = synthesise_surfaces(seeds.propagated, seeds.model, method="synth", house="h", seed=7)
    for key, group in ((KEYS[2], images[:3]), (KEYS[0], images[3:])):
        together = [first[key], *group]
        assert len({image.tobytes() for image in together}) == 4
        means = np.array([image.mean(axis=(0, 1)) for image in together])
        other = images[3 if key == KEYS[2] else 0].mean(axis=(0, 1))
        assert np.ptp(means, axis=0).max() < np.abs(means[0] - other).max()
    again = further_images(seeds, [KEYS[0]], method="synth", house="h")
    for a, b in zip(again, images[3:], strict=True):  # in batches of other sizes: rounding
        assert np.abs(a.astype(int) - b).max() <= 2
    moved = further_images(seeds, [KEYS[0]], method="synth", house="another")
    assert not np.array_equal(moved[0], again[0])


def test_seams_are_corrected_as_on_disk(seeds):
    plain = further_images(seeds, KEYS[:1], method="synth", house="h")
    corrected = FurtherSeeds(**{**vars(seeds), "seam_correction": True})
    found = further_images(corrected, KEYS[:1], method="synth", house="h")
    assert not np.array_equal(plain[0], found[0])
    assert np.array_equal(make_seamless(plain[0])[0], found[0])


def test_one_image_or_no_surface_is_nothing(seeds):
    assert further_images(seeds, [], method="synth", house="h") == []
    one = FurtherSeeds(**{**vars(seeds), "count": 1})
    assert further_images(one, KEYS, method="synth", house="h") == []


def test_the_metrics_stage_keeps_their_features(seeds, tmp_path):
    rng = np.random.default_rng(4)
    image = rng.integers(0, 256, (128, 128, 3), dtype=np.uint8)
    write_png(tmp_path / "textures" / "r1_floor.png", image)
    write_json(
        tmp_path / "textures" / "textures.json",
        {"method": "synth", "surfaces": {"r1/floor": {"observed": True}}},
    )
    columns = ["crop_id", "photo", "room_id", "surface", "png"]
    crops = pd.DataFrame([("a", "p.jpg", "r1", "floor", png_bytes(image))], columns=columns)
    write_parquet(tmp_path / "crops.parquet", crops, {"house": "h"})
    model, names = MODELS / "features.safetensors", {"dataset": "d", "house": "h"}
    given = (tmp_path / "textures", read_references(tmp_path / "crops.parquet", []), model)
    names |= {"method": "synth", "drop": "0.0"}
    measure_house(*given, tmp_path / "one.parquet", **names)
    measure_house(*given, tmp_path / "four.parquet", **names, further=seeds)
    one, four = (read_parquet(tmp_path / f"{n}.parquet")[0].iloc[0] for n in ("one", "four"))
    assert len(one["further_features"]) == 0
    images = further_images(seeds, KEYS[:1], method="synth", house="h")
    expected = features_of(model, images).ravel()
    assert np.allclose(four["further_features"], expected, atol=1e-5)
    assert one["color"] == four["color"] == 0.0
    assert np.array_equal(one["features"], four["features"])


def test_each_surface_counts_once_however_many_images_it_has():
    rng = np.random.default_rng(3)
    surfaces = [("h", f"r{i}", "floor") for i in range(5)]
    columns = ["house", "room_id", "surface"]
    part = pd.DataFrame(surfaces, columns=columns)
    images = [rng.normal(size=(1 + i, 4)) for i in range(5)]
    part["features"] = [group[0] for group in images]
    part["further_features"] = [group[1:].ravel() for group in images]
    crops = [(*surface, rng.normal(0.5, 1, 4)) for surface in surfaces for _ in range(2)]
    crops += [(*surfaces[0], rng.normal(0.5, 1, 4)), ("h", "r9", "wall", np.full(4, 99.0))]
    references = pd.DataFrame(crops, columns=[*columns, "features"])
    found = feature_distances(part, references)
    predicted = np.concatenate(images)
    wanted = np.stack(references["features"][:-1])
    owners = np.repeat(np.arange(5), [1, 2, 3, 4, 5])
    crop_owners = np.array([0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 0])
    for name, distance in (("FID", frechet_distance), ("KID", kernel_distance)):
        expected = distance(predicted, wanted, owners, crop_owners)
        assert found[name] == pytest.approx(expected, rel=1e-12)
