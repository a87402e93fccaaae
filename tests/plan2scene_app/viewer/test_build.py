"""The viewer's file: self-contained, escaped, with the GLB in it."""

import base64
import gzip
import hashlib
import json
import re
from pathlib import Path

import pytest

from plan2scene.errors import InputError
from plan2scene_app.viewer import viewer_page
from plan2scene_app.viewer.viewer_page import build_viewer

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
    assert rules["style-src"] == hashes(r"<style>(.*?)</style>")
    assert "connect-src" not in rules


def test_names_are_escaped(page):
    assert "<h1>&lt;b&gt;&amp;x</h1>" in page
    facts = re.search(r'<script type="application/json" id="facts">(.*?)</script>', page)[1]
    assert json.loads(facts)["surfaces"]["r/floor"]["source"] == "</script><b>&"


def test_the_same_bytes_each_time(small_glb, tmp_path):
    for name in ("a", "b"):
        build_viewer(small_glb, tmp_path / name, house_id="x")
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_no_glb_is_refused(tmp_path):
    (tmp_path / "house.glb").write_bytes(b"PK\x03\x04")
    with pytest.raises(InputError, match=r"house\.glb.*expected a GLB file"):
        build_viewer(tmp_path / "house.glb", tmp_path / "viewer.html", house_id="x")


def test_every_id_of_the_program_is_in_the_page(page):
    used = set(re.findall(r'\$\("([a-z]+)"\)', page))
    assert {"view", "rooms", "info", "facts"} <= used
    assert used <= set(re.findall(r'id="([a-z]+)"', page))


def test_three_is_the_release_that_the_lock_names_and_has_its_licence():
    lock = json.loads((FOLDER / "three" / "package-lock.json").read_text())
    version = lock["packages"]["node_modules/three"]["version"]
    assert f'="{version.split(".")[1]}"' in (FOLDER / "three.min.js").read_text(encoding="utf-8")
    assert "MIT" in (FOLDER / "three.LICENSE.txt").read_text()


def test_all_that_the_program_takes_of_three_is_in_its_bundle():
    bundle = (FOLDER / "three.min.js").read_text(encoding="utf-8")
    exported = set(re.findall(r"(\w+):\(\)=>", bundle))
    own = "".join(
        path.read_text(encoding="utf-8")
        for path in FOLDER.glob("*.js")
        if path.name != "three.min.js"
    )
    used = set(re.findall(r"\bTHREE\.(\w+)", own))
    assert "Vector3" in used
    assert used <= exported
