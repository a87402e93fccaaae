"""Pages: what is put into them stays text and data."""

import base64
import hashlib

from plan2scene.html_page import html_page, inline_json, source_hash


def test_a_title_is_text_and_dollars_of_values_stay(tmp_path):
    body = tmp_path / "body.html"
    body.write_text("<body><h1>$title</h1><script>$program</script></body>")
    page = html_page(body, title="</title><b>", style="p { }", program="`${x}`", policy="p")
    assert page.count("&lt;/title&gt;&lt;b&gt;") == 2
    assert "<script>`${x}`</script>" in page
    assert '<meta http-equiv="Content-Security-Policy" content="p">' in page
    assert "generator" not in page


def test_data_ends_no_script():
    assert inline_json({"a": "</script><!--&"}) == '{"a":"\\u003c/script\\u003e\\u003c!--\\u0026"}'


def test_hash_of_a_source():
    digest = base64.b64encode(hashlib.sha256("é".encode()).digest()).decode()
    assert source_hash("é") == f"'sha256-{digest}'"
