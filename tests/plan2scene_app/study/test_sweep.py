import csv

import numpy as np
import pytest
from PIL import Image

from plan2scene.evaluation.tables import TableRequest
from plan2scene.io import read_parquet
from plan2scene.textures.methods import texture_methods
from plan2scene_app.study.sweep import sweep_house, sweep_table

HIDDEN = {"0.0": [], "0.1": [], "0.5": ["p2.jpg"], "1.0": ["p1.jpg", "p2.jpg", "p3.jpg"]}


@pytest.fixture(scope="module")
def swept(house, embeddings, tmp_path_factory):
    path = tmp_path_factory.mktemp("sweep") / "sweep.parquet"
    sweep_house(house, embeddings, path, hidden=HIDDEN, methods=list(texture_methods()))
    return path


def test_every_method_is_measured_at_every_drop(swept):
    frame, metadata = read_parquet(swept)
    assert (metadata["house"], metadata["features"]) == ("h1", "embedded")
    count = frame.groupby(["method", "drop"]).size()
    assert len(count) == len(texture_methods()) * len(HIDDEN)
    assert set(count) == {4}  # the surfaces that any crop shows
    seen = frame[frame["method"] == "synth"].groupby("drop")["observed"].sum()
    assert seen.to_dict() == {"0.0": 4, "0.1": 4, "0.5": 2, "1.0": 0}
    assert np.isfinite(frame[["color", "freq", "tile"]].to_numpy()).all()


def test_the_table_has_every_cell_and_a_plot(swept, references, tmp_path):
    drops, methods = list(HIDDEN), list(texture_methods())
    request = TableRequest("d", ["h1", "h2"], methods, drop="", seed=0, drops=drops)
    for run in ("a", "b"):
        files = [swept], [references], tmp_path / f"{run}.csv", tmp_path / f"{run}.png"
        sweep_table(*files, request=request)
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    rows = list(csv.DictReader((tmp_path / "a.csv").open()))
    assert len(rows) == len(texture_methods()) * 3 * len(drops)
    assert all(value != "" for row in rows for value in row.values())
    assert {row["missing"] for row in rows} == {"h2"}
    frame, _ = read_parquet(swept)
    for row in rows:
        part = frame[(frame["method"] == row["method"]) & (frame["drop"] == row["drop"])]
        if row["column"] != "all":
            part = part[part["observed"] == (row["column"] == "observed")]
        assert int(row["n"]) == len(part)
        if len(part):
            assert float(row["COLOR"]) == pytest.approx(part["color"].mean(), abs=5e-5)
            assert float(row["SUBS (embedded)"]) == pytest.approx(part["subs"].mean(), abs=5e-5)
        else:
            assert row["COLOR"] == row["FID (embedded)"] == "n=0"
    assert Image.open(tmp_path / "a.png").size[0] > 1000
