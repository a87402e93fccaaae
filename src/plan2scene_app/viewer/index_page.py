"""The index page: every house of a data set with its files, the evaluation table and plot."""

from __future__ import annotations

import csv
import html
import io
import os
from collections.abc import Sequence
from pathlib import Path
from urllib.parse import quote

from plan2scene.io import atomic_path, read_text
from plan2scene.plans.geometry import room_polygon
from plan2scene.plans.scene_json import read_scene_json
from plan2scene_app.html_page import html_page, source_hash

_FOLDER = Path(__file__).parent
#: Files of a house to which the page links, with the links' texts.
_FILES = (
    ("viewer.html", "Open in 3D"),
    ("house.glb", "GLB"),
    ("house.scene.json", "scene.json"),
    ("contact_sheet.png", "photos"),
    ("patterns.jpg", "floors"),
    ("texture_sheet.png", "textures"),
)


def write_index(
    output: str | Path,
    *,
    scenes: Sequence[str | Path],
    table: str | Path,
    plot: str | Path,
    dataset: str,
    method: str,
) -> None:
    """Write ``index.html``; links are relative, so the results folder can be moved.

    Parameters
    ----------
    output : path
        The page.
    scenes : sequence of path
        Files ``houses/{house}/scene.json``; the other files of a house lie beside them.
    table, plot : path
        The evaluation table (CSV) and its plot.
    dataset, method : str
        Shown on the page.
    """
    base = Path(output).parent
    style = (_FOLDER / "index.css").read_text(encoding="utf-8")
    page = html_page(
        _FOLDER / "index.html",
        title=dataset,
        style=style,
        policy=f"default-src 'none'; style-src {source_hash(style)}; img-src 'self' data: file:",
        method=html.escape(method),
        houses="\n".join(_card(Path(scene), base) for scene in scenes),
        table=_table(table),
        table_link=_link(Path(table), base),
        plot_link=_link(Path(plot), base),
    )
    with atomic_path(output) as temporary:
        temporary.write_text(page, encoding="utf-8")


def _link(path: Path, base: Path) -> str:
    """Return a relative URL from the page's folder."""
    return html.escape(quote(Path(os.path.relpath(path, base)).as_posix()))


def _card(scene: Path, base: Path) -> str:
    """Return the HTML of one house: preview, name, size, links."""
    folder = scene.parent
    house = read_scene_json(scene, folder.name)
    area = sum(room_polygon(room).area for room in house.rooms)
    name = html.escape(house.title)
    links = " ".join(
        f'<a href="{_link(folder / file, base)}">{title}</a>' for file, title in _FILES
    )
    rooms = "1 room" if len(house.rooms) == 1 else f"{len(house.rooms)} rooms"
    return (
        f'<article><a href="{_link(folder / "viewer.html", base)}">'
        f'<img src="{_link(folder / "preview.png", base)}" loading="lazy" '
        f'alt="House {name} from above and obliquely"></a>'
        f"<details><summary>Rooms at eye level</summary>"
        f'<img src="{_link(folder / "rooms.jpg", base)}" loading="lazy" '
        f'alt="Rooms of house {name} at eye level"></details>'
        f"<details><summary>Beside its photos</summary>"
        f'<img src="{_link(folder / "views.jpg", base)}" loading="lazy" '
        f'alt="Photos, each beside house {name} from the same place"></details>'
        f"<h3>{name}</h3><p>{rooms}, {area:.1f} m²</p><p>{links}</p></article>"
    )


def _table(path: str | Path) -> str:
    """Return a CSV file as an HTML table; the first row is the head, numbers align to the right."""
    rows = list(csv.reader(io.StringIO(read_text(path))))
    if not rows:
        return "<p>The table is empty.</p>"
    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in rows[0])
    body = "\n".join("<tr>" + "".join(map(_cell, row)) + "</tr>" for row in rows[1:])
    return f"<table><thead><tr>{head}</tr></thead><tbody>\n{body}\n</tbody></table>"


def _cell(text: str) -> str:
    """Return one table cell; floats are shortened to four significant digits."""
    try:
        value = float(text)
    except ValueError:
        return f"<td>{html.escape(text)}</td>"
    figure = text if text.lstrip("-").isdigit() else f"{value:.4g}"
    return f'<td class="figure">{html.escape(figure)}</td>'
