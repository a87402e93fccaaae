"""What the viewer tells of surfaces and photos, out of the results' tables."""

import base64

import cv2
import numpy as np
import pandas as pd

from plan2scene.images import png_bytes
from plan2scene.io import write_json
from plan2scene_app.viewer.viewer_page import read_facts


def tables(tmp_path):
    """Write three surfaces, a photo's crop, two cameras; return the paths."""
    rows = [
        ("r", "floor", True, "floor/a_0_crop0", 1.0),
        ("r", "wall", False, "propagated, like s", 0.61234567),
        ("r", "ceiling", False, "mean of ceilings", np.nan),
    ]
    names = ["room_id", "surface", "observed", "source", "confidence"]
    pd.DataFrame(rows, columns=names).to_parquet(tmp_path / "propagated.parquet")
    png = png_bytes(np.full((128, 128, 3), (200, 100, 40), np.uint8))
    crops = [("floor/a_0_crop0", "a.jpg", png), ("floor/b_0_crop0", "b.jpg", png)]
    frame = pd.DataFrame(crops, columns=["crop_id", "photo", "png"])
    frame.to_parquet(tmp_path / "crops.parquet")
    shared = {"width": 4, "height": 3, "focal_px": 5.0, "rotation": [[1, 0, 0]], "located": 0.7}
    write_json(
        tmp_path / "cameras.json",
        {
            "a.jpg": {**shared, "room_id": "r", "position": [1.0, 1.4, 2.0], "cx": 2},
            "0.jpg": {**shared, "room_id": None, "position": None},
        },
    )
    return [tmp_path / n for n in ("propagated.parquet", "crops.parquet", "cameras.json")]


def test_crops_of_observed_and_confidence_of_others(tmp_path):
    surfaces = read_facts(*tables(tmp_path))["surfaces"]
    floor = surfaces["r/floor"]
    assert floor["photo"] == "a.jpg"
    head, data = floor["crop"].split(",")
    assert head == "data:image/jpeg;base64"
    image = cv2.imdecode(np.frombuffer(base64.b64decode(data), np.uint8), cv2.IMREAD_COLOR)
    assert image.shape == (128, 128, 3)
    assert np.abs(image.astype(int) - (40, 100, 200)).max() <= 3
    assert surfaces["r/wall"] == {"confidence": 0.6123, "source": "propagated, like s"}
    assert surfaces["r/ceiling"]["confidence"] is None


def test_photos_are_numbered_by_name_and_only_located_ones_have_a_camera(tmp_path):
    photos = read_facts(*tables(tmp_path))["photos"]
    assert [(p["name"], p["number"]) for p in photos] == [("0.jpg", 1), ("a.jpg", 2), ("b.jpg", 3)]
    assert [p.get("position") for p in photos] == [None, [1.0, 1.4, 2.0], None]
    assert photos[1]["room_id"] == "r" and photos[1]["located"] == 0.7
    assert "focal_px" not in photos[0]


def test_ready_crops_have_no_cameras(tmp_path):
    propagated, crops, _ = tables(tmp_path)
    facts = read_facts(propagated, crops, None)
    assert facts["photos"] == [{"name": "a.jpg", "number": 1}, {"name": "b.jpg", "number": 2}]
