import tracemalloc

import numpy as np
import pandas as pd
import pytest
from whole_sets import set_distances

from plan2scene.evaluation.measurements import Measurements
from plan2scene.evaluation.tables import TableRequest, tidy_table
from plan2scene.io import read_parquet, write_parquet
from plan2scene.metrics.feature_sets import kernel_distance

NETWORKS = {"features": "embedded", "model": "a", "substances": "vgg16", "substance_model": "b"}
METHODS = ("synth", "crop")
COLUMNS = ["room_id", "surface"]


def _features(rng, dimension):
    return rng.normal(0.3, 1.0, dimension).astype(np.float32)


def _house(folder, name, seed, dimension, surfaces=3, crops=5):
    rng = np.random.default_rng(seed)
    keys = [(f"r{i}", "floor" if i % 2 else "wall") for i in range(surfaces)]
    rows = [
        {
            **{"house": name, "room_id": key[0], "surface": key[1], "observed": i != 1},
            **{"method": method, "drop": drop, "color": rng.random(), "freq": rng.random()},
            **{"tile": np.nan if i == 0 else rng.random(), "subs": int(rng.integers(2))},
            "features": _features(rng, dimension),
            "further_features": _features(rng, (i % 2) * dimension),
        }
        for method in METHODS
        for drop in ("0.0", "0.6")
        for i, key in enumerate(keys)
    ]
    shown = [
        {"room_id": key[0], "surface": key[1], "features": _features(rng, dimension)}
        for key in keys[:-1]  # the last surface has no crop
        for _ in range(crops)
    ]
    paths = folder / f"{name}.metrics", folder / f"{name}.references"
    write_parquet(paths[0], pd.DataFrame(rows), NETWORKS)
    write_parquet(paths[1], pd.DataFrame(shown), {"house": name})
    return paths


def _files(folder, count, dimension=4, **more):
    folder.mkdir(exist_ok=True)
    pairs = [_house(folder, f"h{i}", i, dimension, **more) for i in range(count)]
    return [list(paths) for paths in zip(*pairs, strict=True)]


def _request(count):
    return TableRequest("d", [f"h{i}" for i in range(count)], METHODS, "0.6", 0)


def _loaded(files, method, column, drop):
    metrics = pd.concat([read_parquet(path)[0] for path in files[0]], ignore_index=True)
    parts = [read_parquet(path) for path in files[1]]
    references = pd.concat([frame.assign(house=meta["house"]) for frame, meta in parts])
    part = metrics[(metrics["method"] == method) & (metrics["drop"] == drop)]
    if column != "all":
        part = part[part["observed"] == (column == "observed")]
    dimension = len(part["features"].iloc[0])
    pairs = zip(part["features"], part["further_features"], strict=True)
    images = [np.concatenate(pair).reshape(-1, dimension) for pair in pairs]
    owners = np.repeat(np.arange(len(images)), [len(own) for own in images])
    crops = references.merge(part[["house", *COLUMNS]], on=["house", *COLUMNS])
    codes = crops.groupby(["house", *COLUMNS]).ngroup().to_numpy()
    sets = (np.concatenate(images), np.stack(list(crops["features"])), owners, codes)
    figures = {name: part[name.lower()].mean() for name in ("COLOR", "FREQ", "TILE", "SUBS")}
    return figures | {"FID": set_distances(*sets)["FID"], "KID": kernel_distance(*sets)}


@pytest.mark.parametrize("dimension", [4, 200])
def test_house_by_house_is_all_houses_at_once(tmp_path, dimension):
    files = _files(tmp_path, 7, dimension)
    tidy = tidy_table(Measurements(*files), _request(7))
    found = tidy.set_index(["method", "column", "drop", "metric"])["value"]
    for (method, column, drop), _ in tidy.groupby(["method", "column", "drop"]):
        for name, value in _loaded(files, method, column, drop).items():
            assert found[method, column, drop, name] == pytest.approx(value, rel=1e-9), name
    assert set(tidy["houses"]) == {7}
    networks = dict(zip(tidy["metric"], tidy["features"], strict=True))
    assert networks["SUBS"] == "vgg16" and networks["FID"] == networks["KID"] == "embedded"
    assert networks["COLOR"] == "none"


def test_memory_does_not_grow_with_the_houses(tmp_path):
    files = _files(tmp_path, 30, 16, crops=100)
    tidy_table(Measurements(*([paths[:2] for paths in files])), _request(2))
    peaks = []
    for count in (10, 30):
        tracemalloc.start()
        tidy_table(Measurements(*([paths[:count] for paths in files])), _request(count))
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] - peaks[0] < 60 * 1024  # the crops of the 20 houses alone are 250 KiB
