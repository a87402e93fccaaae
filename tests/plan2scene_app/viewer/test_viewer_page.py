import base64
import gzip
import hashlib
import re
from pathlib import Path

import cv2
import numpy as np
import pandas as pd
import pytest

from plan2scene.errors import InputError
from plan2scene.images import png_bytes
from plan2scene.io import write_json
from plan2scene_app.viewer import viewer_page
from plan2scene_app.viewer.viewer_page import build_viewer, read_facts

FOLDER = Path(viewer_page.__file__).parent


@pytest.fixture
def page(small_glb, tmp_path):
    facts = {"surfaces": {"r/floor": {"source": "</script><b>&"}}, "photos": []}
    build_viewer(small_glb, tmp_path / "viewer.html", house_id="<b>&x", facts=facts)
    return (tmp_path / "viewer.html").read_text(encoding="utf-8")


def test_one_file_without_the_network(page, small_glb):
    own = page.replace((FOLDER / "three.min.js").read_text(encoding="utf-8"), "")
    assert not re.search(r"""(src|href)\s*=\s*["']?(https?:)?//""", own)
    assert "://" not in own
    data = re.search(r'<script type="application/octet-stream" id="house">([^<]*)</script>', page)
    assert gzip.decompress(base64.b64decode(data[1])) == small_glb.read_bytes()
    assert page.count("</script>") == 4


def test_the_policy_knows_the_scripts_and_the_style_by_hash(page):
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', page)[1]
    assert "default-src 'none'" in policy and "unsafe" not in policy

    def hashes(pattern):
        texts = re.findall(pattern, page, flags=re.DOTALL)
        digests = (hashlib.sha256(text.encode()).digest() for text in texts)
        return [f"'sha256-{base64.b64encode(digest).decode()}'" for digest in digests]

    rules = {rule.split()[0]: rule.split()[1:] for rule in policy.split("; ")}
    assert rules["script-src"] == hashes(r"<script>(.*?)</script>")
    assert len(rules["script-src"]) == 2
    assert rules["style-src"] == hashes(r"<style>(.*?)</style>") and "connect-src" not in rules


def test_the_same_bytes_each_time_and_no_glb_is_refused(small_glb, tmp_path):
    for name in ("a", "b"):
        build_viewer(small_glb, tmp_path / name, house_id="x")
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
    (tmp_path / "house.glb").write_bytes(b"PK\x03\x04")
    with pytest.raises(InputError, match=r"house\.glb.*expected a GLB file"):
        build_viewer(tmp_path / "house.glb", tmp_path / "viewer.html", house_id="x")


def tables(tmp_path):
    rows = [
        ("r", "floor", True, "floor/a_0_crop0", 1.0),
        ("r", "wall", False, "propagated, like s", 0.61234567),
        ("r", "ceiling", False, "mean of ceilings", np.nan),
    ]
    names = ["room_id", "surface", "observed", "source", "confidence"]
    pd.DataFrame(rows, columns=names).to_parquet(tmp_path / "propagated.parquet")
    png = png_bytes(np.full((128, 128, 3), (200, 100, 40), np.uint8))
    crops = [("floor/a_0_crop0", "a.jpg", png), ("floor/b_0_crop0", "b.jpg", png)]
    pd.DataFrame(crops, columns=["crop_id", "photo", "png"]).to_parquet(tmp_path / "crops.parquet")
    shared = {"width": 4, "height": 3, "focal_px": 5.0, "cx": 2, "cy": 1, "located": 0.7}
    shared |= {"rotation": np.eye(3).tolist()}
    write_json(
        tmp_path / "cameras.json",
        {
            "a.jpg": {**shared, "room_id": "r", "position": [1.0, 1.4, 2.0]},
            "0.jpg": {**shared, "room_id": None, "position": None},
        },
    )
    return [tmp_path / n for n in ("propagated.parquet", "crops.parquet", "cameras.json")]


def test_facts_of_surfaces_and_photos(tmp_path):
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
    photos = read_facts(*tables(tmp_path))["photos"]
    assert [(p["name"], p["number"]) for p in photos] == [("0.jpg", 1), ("a.jpg", 2), ("b.jpg", 3)]
    assert [p.get("position") for p in photos] == [None, [1.0, 1.4, 2.0], None]
    assert photos[1]["room_id"] == "r" and photos[1]["located"] == 0.7
    assert "focal_px" not in photos[0]
