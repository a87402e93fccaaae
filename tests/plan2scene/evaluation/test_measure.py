import numpy as np
import pandas as pd
import pytest
import torch
from whole_sets import set_distances

from plan2scene.errors import InputError
from plan2scene.evaluation.measure import Networks, measure_tiles, reference_features
from plan2scene.evaluation.references import reference_images
from plan2scene.evaluation.tables import TableRequest, paper_table, published_value
from plan2scene.house import SurfaceKey
from plan2scene.images import png_bytes
from plan2scene.io import read_parquet, write_parquet
from plan2scene.metrics.color_freq_tile import color_distance, freq_distance, tile_score
from plan2scene.metrics.substance_network import SubstanceNetwork
from plan2scene.weights import save_model_file

METHODS = ("crop", "synth")


def _noise(seed, level=120):
    rng = np.random.default_rng(seed)
    return np.clip(rng.normal(level, 25, (128, 128, 3)), 0, 255).astype(np.uint8)


#: crop id -> (photo, room, surface, image); the wall is seen by the hidden photo only.
CROPS = {
    "a": ("p1.jpg", "r1", "floor", _noise(1)),
    "b": ("p1.jpg", "r1", "floor", _noise(2)),
    "c": ("p2.jpg", "r1", "floor", _noise(3, 200)),
    "d": ("p2.jpg", "r1", "wall", _noise(4, 80)),
}


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    path = tmp_path_factory.mktemp("model") / "features.safetensors"
    torch.manual_seed(1)
    network = SubstanceNetwork((4, 6), feature_dim=6)
    save_model_file(path, network.state_dict(), network.architecture)
    return path


def _references(hidden):
    rows = [(i, photo, room, s, png_bytes(image)) for i, (photo, room, s, image) in CROPS.items()]
    frame = pd.DataFrame(rows, columns=["crop_id", "photo", "room_id", "surface", "png"])
    return frame, reference_images(frame, hidden)


def _measured(house, tiles, observed, method, drop, model, hidden, more=()):
    return measure_tiles(
        {SurfaceKey(*name.split("/")): image for name, image in tiles.items()},
        {SurfaceKey(*name.split("/")) for name in observed},
        _references(hidden)[1],
        Networks(model, model),
        **{"house_id": house, "method": method, "drop": drop, "more": more},
    )


TILES = {"r1/floor": _noise(11), "r1/wall": _noise(12, 90), "r1/ceiling": _noise(13)}


def test_values_are_those_of_the_metrics(model):
    frame = _measured("h", TILES, {"r1/floor"}, "synth", "0.6", model, ["p2.jpg"])
    # The ceiling has no crop at all: no row.
    assert frame["surface"].tolist() == ["floor", "wall"]
    assert frame["observed"].tolist() == [True, False]
    floor, wall = frame.itertuples()
    reference = CROPS["a"][3]  # of two visible crops both are as near to their mean: the first
    assert floor.color == color_distance(TILES["r1/floor"], reference)
    assert floor.freq == pytest.approx(freq_distance(TILES["r1/floor"], reference), abs=1e-9)
    assert floor.tile == pytest.approx(tile_score(TILES["r1/floor"]))
    assert wall.color == color_distance(TILES["r1/wall"], CROPS["d"][3])
    assert floor.subs == int(floor.substance_predicted != floor.substance_reference)
    assert len(wall.features) == 6 and len(wall.further_features) == 0


def test_an_observed_surface_without_visible_crop_is_a_fault(model):
    with pytest.raises(InputError, match=r"house h, room r1: expected a visible crop of wall"):
        _measured("h", TILES, {"r1/wall"}, "crop", "0.6", model, ["p2.jpg"])


@pytest.fixture
def results(tmp_path, model):
    for house, seed in (("h1", 0), ("h2", 50)):
        folder, frames = tmp_path / "houses" / house, []
        for method in METHODS:
            for drop, hidden in (("0.0", []), ("0.6", ["p2.jpg"])):
                tiles = {name: _noise(seed + i, 110 + 9 * i) for i, name in enumerate(TILES)}
                seen = {"r1/floor"} if hidden else {"r1/floor", "r1/wall"}
                frames.append(_measured(house, tiles, seen, method, drop, model, hidden))
        names = {"dataset": "d", "house": house}
        table = pd.concat(frames, ignore_index=True)
        write_parquet(folder / "metrics.parquet", table, names | Networks(model, model).metadata)
        write_parquet(folder / "crops.parquet", _references([])[0], names)
        references = folder / "reference_features.parquet"
        reference_features(folder / "crops.parquet", model, references, dataset="d", house=house)
    return tmp_path


def _rows(results, method, drop):
    paths = sorted(results.glob("houses/*/metrics.parquet"))
    frame = pd.concat([read_parquet(path)[0] for path in paths])
    return frame[(frame["method"] == method) & (frame["drop"] == drop)]


def _rewritten(results, change):
    for path in sorted(results.glob("houses/*/metrics.parquet")):
        frame, metadata = read_parquet(path)
        write_parquet(path, change(frame), metadata)


def _request(houses=("h1", "h2"), methods=METHODS):
    return TableRequest("d", houses, methods, drop="0.6", seed=7)


def _table(root, request):
    metrics = sorted(root.glob("houses/*/metrics.parquet"))
    references = sorted(root.glob("houses/*/reference_features.parquet"))
    outputs = [root / "tables" / f"t.{suffix}" for suffix in ("csv", "parquet", "tex")]
    tidy = paper_table(metrics, references, *outputs, request=request)
    return tidy, pd.read_csv(outputs[0], dtype=str, keep_default_na=False)


def test_table_counts_and_averages_the_right_surfaces(results):
    tidy, wide = _table(results, _request())
    assert len(wide) == len(METHODS) * 3
    assert wide["column"].tolist() == ["observed", "unobserved", "all"] * 2
    assert wide["n"].tolist() == ["4", "2", "4"] * 2 and (wide != "").all(axis=None)
    assert wide.loc[0, "missing"] == "none" and wide["seed"].unique().tolist() == ["7"]
    cells = tidy.set_index(["method", "column", "metric"])["value"]
    frame = _rows(results, "synth", "0.6")
    unobserved = frame[~frame["observed"]]
    assert cells["synth", "unobserved", "COLOR"] == pytest.approx(unobserved["color"].mean())
    assert cells["synth", "all", "TILE"] == pytest.approx(frame["tile"].mean())
    files = sorted(results.glob("houses/*/reference_features.parquet"))
    walls = pd.concat([read_parquet(file)[0] for file in files]).query("surface == 'wall'")
    expected = set_distances(np.stack(unobserved["features"]), np.stack(walls["features"]))
    for name in ("FID", "KID"):
        assert cells["synth", "unobserved", name] == pytest.approx(expected[name], rel=1e-6)
    row = wide[(wide["method"] == "synth") & (wide["column"] == "all")].iloc[0]
    paper = {"COLOR": 0.591, "FREQ": 0.034, "SUBS": 0.392, "FID": 196.2, "TILE": 17.6}
    for name, figure in paper.items():
        assert float(row[f"{name} published"]) == figure == published_value("synth", "all", name)
    assert row["KID published"] == row["KID difference"] == "none"
    # Only what is of one network's scale is subtracted.
    assert row["SUBS difference"] == row["FID difference"] == "other network"
    assert float(row["TILE difference"]) == pytest.approx(float(row["TILE"]) - 17.6, abs=1e-4)
    assert row["images"] == row["n"] and f"numpy {np.__version__}" in row["packages"]
    assert float(row["KID (embedded)"]) == pytest.approx(cells["synth", "all", "KID"], abs=1e-3)
    assert float(row["FID (embedded)"]) == pytest.approx(cells["synth", "all", "FID"], abs=1e-3)


def test_missing_houses_and_empty_columns_are_named(results):
    _rewritten(results, lambda f: f[(f["method"] != "synth") | (f["drop"] != "0.6")])
    _, wide = _table(results, _request(houses=("h1", "h2", "h3")))
    empty = wide[(wide["method"] == "synth") & (wide["column"] == "all")].iloc[0]
    assert (empty["n"], empty["houses"], empty["COLOR"]) == ("0", "0", "n=0")
    assert empty["missing"] == "h1 h2 h3"
    assert wide.loc[0, "missing"] == "h3" and (wide != "").all(axis=None)


def test_metrics_of_two_networks_are_not_mixed(results):
    path = results / "houses" / "h1" / "metrics.parquet"
    frame, metadata = read_parquet(path)
    write_parquet(path, frame, metadata | {"model": "another"})
    with pytest.raises(InputError, match="one features network"):
        _table(results, _request())
