"""Houses' measurements are put together, those of different networks refused."""

import pandas as pd
import pytest

from plan2scene.errors import InputError
from plan2scene.evaluation.gather import read_metrics, read_references
from plan2scene.io import write_parquet

NETWORKS = {"features": "embedded", "model": "a", "substances": "vgg16", "substance_model": "b"}


def test_metrics_of_all_houses_with_each_metric_s_network(tmp_path):
    for house in ("h1", "h2"):
        frame = pd.DataFrame({"house": [house], "color": [0.5]})
        write_parquet(tmp_path / f"{house}.parquet", frame, NETWORKS)
    write_parquet(tmp_path / "none.parquet", frame[:0], NETWORKS)
    found, networks = read_metrics(sorted(tmp_path.iterdir()))
    assert found["house"].tolist() == ["h1", "h2"]
    assert networks["SUBS"] == "vgg16" and networks["FID"] == networks["KID"] == "embedded"
    assert networks["COLOR"] == "none"


def test_another_network_is_refused(tmp_path):
    frame = pd.DataFrame({"house": ["h"]})
    for k, model in enumerate("xy"):
        write_parquet(tmp_path / f"{k}.parquet", frame, NETWORKS | {"model": model})
    with pytest.raises(InputError, match="one features network"):
        read_metrics(sorted(tmp_path.iterdir()))


def test_references_know_their_house_and_none_is_a_table_too(tmp_path):
    frame = pd.DataFrame({"room_id": ["r"], "surface": ["wall"], "features": [[1.0]]})
    write_parquet(tmp_path / "a.parquet", frame, {"house": "h7"})
    assert read_references([tmp_path / "a.parquet"])["house"].tolist() == ["h7"]
    write_parquet(tmp_path / "b.parquet", frame[:0], {"house": "h8"})
    empty = read_references([tmp_path / "b.parquet"])
    assert empty.empty and "features" in empty.columns
