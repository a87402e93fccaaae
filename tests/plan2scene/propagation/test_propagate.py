import numpy as np
import pandas as pd
import pytest

from plan2scene.io import read_parquet, write_parquet
from plan2scene.plans.scene_writer import write_scene_json
from plan2scene.propagation.propagate import propagate_house
from plan2scene.weights import MODELS

WEIGHTS = {f"{name}_model": MODELS / f"{name}.safetensors" for name in ("propagation", "texture")}


def test_a_black_floor_that_no_crop_shows_is_black_and_said_to_be_seen(shared_house, tmp_path):
    first, second = (room.id for room in shared_house.rooms)
    write_scene_json(shared_house, tmp_path / "scene.json")
    wall = {"room_id": first, "surface": "wall", "crop_id": "c", "substance": "plaster"}
    code = np.r_[np.zeros(8), [0.7] * 3].astype(np.float32)
    wall |= {"metres": 1.0, "embedding": code, "naive_embedding": code[:8]}
    write_parquet(tmp_path / "surfaces.parquet", pd.DataFrame([wall]), {})
    rows = [
        {"photo": "a.jpg", "room_id": room, "surface": kind, "weight": 0.02, "own": True}
        | {"colours": np.full(96, grey, np.float32)}
        for room, kind, grey in ((first, "wall", 0.45), (second, "floor", 0.002))
    ]
    write_parquet(tmp_path / "colours.parquet", pd.DataFrame(rows), {"colours": "photo"})
    given = [tmp_path / name for name in ("scene.json", "surfaces.parquet", "out.parquet")]
    names = {"house": "h1", "dataset": "d", "predictor": "house", **WEIGHTS}
    propagate_house(*given, colours=tmp_path / "colours.parquet", **names)
    table = read_parquet(given[-1])[0].set_index(["room_id", "surface"])
    black, unseen = table.loc[(second, "floor")], table.loc[(first, "floor")]
    assert max(black.colour) < 0.1 < min(unseen.colour)
    np.testing.assert_array_equal(black.embedding[-3:], black.colour)
    assert not black.observed and black.confidence < 1.0
    assert black.source.endswith(", its colour seen in part")
    assert "seen" not in unseen.source and table.loc[(first, "wall")].source == "c"
    propagate_house(*given, colours=tmp_path / "colours.parquet", hidden_photos=["a.jpg"], **names)
    hidden = read_parquet(given[-1])[0].set_index(["room_id", "surface"]).loc[(second, "floor")]
    assert min(hidden.colour) > 0.1 and "seen" not in hidden.source
    assert hidden.confidence == pytest.approx(black.confidence)
