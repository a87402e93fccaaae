import json

import numpy as np
import pandas as pd
import pytest
from PIL import Image

from plan2scene.images import png_bytes, write_png
from plan2scene.io import write_parquet
from plan2scene_app.pictures.texture_sheet import draw_sheet, sheet_rows, write_texture_sheet

RED, BLUE = (np.full((128, 128, 3), c, np.uint8) for c in ((200, 30, 30), (30, 30, 200)))


@pytest.fixture
def house(tmp_path):
    listing = {}
    for name, seen in (("hall/wall", False), ("hall/floor", True), ("attic/floor", False)):
        listing[name] = {"observed": seen, "substance": "wood", "size_m": 1.0, "source": "x"}
    for method, image in (("synth", RED), ("exemplar", BLUE)):
        folder = tmp_path / method
        folder.mkdir()
        (folder / "textures.json").write_text(json.dumps({"surfaces": listing}))
        for name in listing:
            write_png(folder / f"{name.replace('/', '_')}.png", image)
    crop = {"crop_id": "c", "photo": "p.jpg", "room_id": "hall", "surface": "floor"}
    frame = pd.DataFrame([crop | {"png": png_bytes(RED), "metres": 1.0, "sharpness": 1.0}])
    write_parquet(tmp_path / "crops.parquet", frame, {"house": "h"})
    return tmp_path


def test_rows_by_room_and_surface_with_their_references(house):
    folders = {name: house / name for name in ("synth", "exemplar")}
    rows = sheet_rows(folders, house / "crops.parquet")
    assert [f"{k.room_id}/{k.surface}" for k in rows] == ["attic/floor", "hall/floor", "hall/wall"]
    shown = next(row for key, row in rows.items() if tuple(key) == ("hall", "floor"))
    assert np.array_equal(shown.reference, RED)
    assert shown.color("synth") == 0.0 and shown.color("exemplar") == 1.0
    assert shown.title == ("hall", "floor", "wood", "observed")
    others = [row for key, row in rows.items() if tuple(key) != ("hall", "floor")]
    assert all(row.reference is None and np.isnan(row.color("synth")) for row in others)


def test_the_picture_has_a_column_for_each_method(house):
    folders = {name: house / name for name in ("synth", "exemplar")}
    write_texture_sheet(house / "sheet.png", folders, house / "crops.parquet", house="h")
    page = np.asarray(Image.open(house / "sheet.png"))
    red, blue = ((page == np.array(c)).all(2).any(0).sum() for c in ((200, 30, 30), (30, 30, 200)))
    assert red == 2 * 192 and blue == 192  # reference and synth; exemplar
    assert draw_sheet("nothing", []).size[0] > 100
