"""Tables house by house: the figures of all houses at once, memory that does not grow."""

import tracemalloc

import numpy as np
import pandas as pd
import pytest

from plan2scene.evaluation.measurements import Measurements
from plan2scene.evaluation.tables import (
    TABLE_COLUMNS,
    TableRequest,
    latex_table,
    published_value,
    tidy_table,
)
from plan2scene.io import read_parquet, write_parquet
from plan2scene.metrics.feature_sets import frechet_distance, kernel_distance
from plan2scene.metrics.registry import METRICS

NETWORKS = {"features": "embedded", "model": "a", "substances": "vgg16", "substance_model": "b"}
METHODS = ("synth", "crop")
COLUMNS = ["room_id", "surface"]


def _features(rng, dimension):
    return rng.normal(0.3, 1.0, dimension).astype(np.float32)


def _house(folder, name, seed, dimension, surfaces=3, crops=5):
    """Write the two tables of a house of random measurements; return their paths."""
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
    """Return a cell's figures with all houses held at once."""
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
    return figures | {"FID": frechet_distance(*sets), "KID": kernel_distance(*sets)}


def _values(tidy):
    return tidy.set_index(["method", "column", "drop", "metric"])["value"]


@pytest.mark.parametrize("dimension", [4, 200])
def test_house_by_house_is_all_houses_at_once(tmp_path, dimension):
    files = _files(tmp_path, 7, dimension)
    tidy = tidy_table(Measurements(*files), _request(7))
    found = _values(tidy)
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


def test_a_house_without_rows_is_missing(tmp_path):
    files = _files(tmp_path, 2)
    frame, metadata = read_parquet(files[0][1])
    write_parquet(files[0][1], frame[:0], metadata)
    tidy = tidy_table(Measurements(*files), _request(2))
    assert set(tidy["missing"]) == {"h1"}
    assert set(tidy["houses"]) == {1}


VALUES = {
    ("crop", "observed"): (0.0, 0.0, 0.0, 0.0516, 34.66, -0.0104),
    ("synth", "observed"): (0.3294, 0.0157, 0.125, 1.9172, 17.43, 0.2),
    ("medoid_colour", "observed"): (0.3291, 0.0162, 0.25, 2.5, 17.35, -0.0003),
    ("crop", "unobserved"): (0.757, 0.0371, 0.318, 3.302, 35.52, 0.1),
    ("synth", "unobserved"): (0.68, 0.018, 0.364, 8.283, 13.72, 0.4),
    ("medoid_colour", "unobserved"): (float("nan"),) * 6,
}


def _made_up():
    networks = {"SUBS": "vgg16", "FID": "embedded", "KID": "embedded"}
    rows = []
    for method in ("crop", "synth", "medoid_colour"):
        for column in TABLE_COLUMNS:
            values = VALUES.get((method, column), (0.5, 0.5, 0.5, 0.5, 0.5, 0.5))
            missing = values[0] != values[0]
            for metric, value in zip(METRICS, values, strict=True):
                rows.append(
                    {
                        "dataset": "demo",
                        "method": method,
                        "column": column,
                        "n": 0 if missing else 22 if column == "unobserved" else 48,
                        "seed": 0,
                        "version": "9.9",
                        "packages": "numpy 2.0, scipy 1.12",
                        "metric": metric,
                        "features": networks.get(metric, "none"),
                        "value": value,
                        "published": published_value(method, column, metric),
                    }
                )
    return pd.DataFrame(rows)


def _latex_rows(text):
    """Return the cells of each row of a table's body; a group's name stands in its first row."""
    lines = [line.removesuffix(" \\\\") for line in text.splitlines() if " & " in line]
    return [line.split(" & ") for line in lines]


def test_latex_by_value():
    text = latex_table(_made_up(), ["of a test"])
    assert text.startswith("% data set demo, seed 0, plan2scene 9.9\n% numpy 2.0, scipy 1.12\n")
    assert "% of a test\n\\begin{tabular}{llrrrrrr}\n\\toprule\n" in text
    head, crop, synth, medoid, *others = _latex_rows(text)
    assert head[2:6] == ["COLOR", "FREQ", "SUBS (vgg16)", "FID (embedded)"]
    # Crop compared with itself is never the best.
    assert crop[:4] == ["Observed (n = 48)", "crop", "0.000 (0.000)", "0.000 (0.000)"]
    assert synth[1:4] == ["synth", r"\textbf{0.329} (0.431)", r"\textbf{0.016} (0.035)"]
    assert synth[5:] == [r"\textbf{1.917} (196.1)", r"\textbf{17.4} (16.4)", "0.200"]
    assert medoid[1:3] == [r"medoid\_colour", r"\textbf{0.329}"] and medoid[-1] == r"\textbf{0.000}"
    assert others[0][0] == "Unobserved (n = 0 to 22)"
    assert others[0][4] == r"\textbf{0.318} (0.345)"
    assert others[2][1:] == [r"medoid\_colour", *["--"] * 6]
    assert others[3][0] == "All (n = 48)" and others[3][2] == r"\textbf{0.500} (0.459)"
