"""The viewer's file: self-contained, escaped, with the GLB in it."""

import base64
import re

import pytest

from plan2scene.errors import InputError
from plan2scene.viewer import build_viewer


def test_one_file_without_the_network(small_glb, tmp_path):
    build_viewer(small_glb, tmp_path / "viewer.html", house_id="small")
    page = (tmp_path / "viewer.html").read_text(encoding="utf-8")
    assert not re.search(r"""(src|href)\s*=\s*["']?(https?:)?//""", page)
    assert "https://" not in page
    assert "default-src 'none'" in page
    data = re.search(r'<script type="application/octet-stream" id="house">([^<]*)</script>', page)
    assert base64.b64decode(data[1]) == small_glb.read_bytes()
    assert page.count("</script>") == 2


def test_the_title_is_escaped(small_glb, tmp_path):
    build_viewer(small_glb, tmp_path / "viewer.html", house_id="<b>&x")
    page = (tmp_path / "viewer.html").read_text(encoding="utf-8")
    assert "<h1>&lt;b&gt;&amp;x</h1>" in page


def test_no_glb_is_refused(tmp_path):
    (tmp_path / "house.glb").write_bytes(b"PK\x03\x04")
    with pytest.raises(InputError, match=r"house\.glb.*expected a GLB file"):
        build_viewer(tmp_path / "house.glb", tmp_path / "viewer.html", house_id="x")


def test_every_id_of_the_program_is_in_the_page(small_glb, tmp_path):
    build_viewer(small_glb, tmp_path / "viewer.html", house_id="small")
    page = (tmp_path / "viewer.html").read_text(encoding="utf-8")
    used = set(re.findall(r'\$\("([a-z]+)"\)', page))
    assert {"view", "rooms", "info"} <= used
    assert used <= set(re.findall(r'id="([a-z]+)"', page))
