import re
from urllib.parse import unquote

from index_page import index_page


def test_links_figures_and_escaping(tmp_path, small_house):
    folder = tmp_path / "houses" / "small"
    folder.mkdir(parents=True)
    files = "viewer.html house.glb house.scene.json preview.png rooms.jpg views.jpg"
    for name in (*files.split(), "contact_sheet.png", "texture_sheet.png", "patterns.jpg"):
        (folder / name).write_bytes(b"x")
    (tmp_path / "table.png").write_bytes(b"x")
    rows = "method,n,color,note\nsynth,12,0.123456,a<b\ncrop,7,,none\n"
    page = index_page(tmp_path, small_house, rows, "demo & more", "synth")
    page = page.read_text(encoding="utf-8")
    links = re.findall(r'(?:href|src)="((?!data:)[^"]+)"', page)
    assert "houses/small/viewer.html" in links and "houses/small/house.glb" in links
    assert {"houses/small/preview.png", "houses/small/views.jpg"} <= set(links)
    for link in links:
        assert not link.startswith(("/", "http")) and (tmp_path / unquote(link)).is_file()
    assert "demo &amp; more" in page and "1 room, 12.0 m²" in page
    assert '<td class="figure">0.1235</td>' in page and '<td class="figure">12</td>' in page
    assert "<td>a&lt;b</td>" in page
