"""The editor's page: its program, style, rules and what it opens in one file without requests."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import re
from collections.abc import Sequence
from graphlib import TopologicalSorter
from pathlib import Path
from string import Template
from typing import Any

from plan2scene.editor.rules import page_rules
from plan2scene.errors import InputError
from plan2scene.floorplans import read_plan, validate_house
from plan2scene.floorplans.plan_writer import house_to_plan
from plan2scene.image_modes import to_small_srgb
from plan2scene.images import decode_image, png_bytes
from plan2scene.io import atomic_path

FOLDER = Path(__file__).parent
#: Pictures of plans are reduced to this many pixels of the longer side.
PICTURE_SIDE = 2400
#: What pages begin with, so that no other file is overwritten.
_MARK = b'<meta name="generator" content="plan2scene edit">'
_IMPORT = re.compile(r'^import (?:\{[^}]*\} from )?"\./(\w+)\.js";\n', re.MULTILINE)


def write_editor(
    source: Path | None, output: Path, *, house_id: str, metres_per_pixel: float | None = None
) -> None:
    """Write the page that edits a plan of any format, draws over a picture, or starts empty.

    Parameters
    ----------
    source : path or None
        A plan that :func:`plan2scene.floorplans.read_plan` reads, or a picture of one.
    output : path
        An HTML file; it opens from the disk in any browser.
    house_id : str
        Shown as the title.
    metres_per_pixel : float, optional
        Scale of a picture, or of a plan in pixels.
    """
    if output.is_file() and _MARK not in output.read_bytes()[:2000]:
        raise InputError("an --out that is no other file", "a file of yours", file=output)
    start: dict[str, Any] = {"house": house_id}
    if source is not None:
        start |= opened(source, house_id, metres_per_pixel)
    with atomic_path(output) as temporary:
        temporary.write_text(editor_page(start), encoding="utf-8")


def opened(source: Path, house_id: str, metres_per_pixel: float | None) -> dict[str, Any]:
    """Return what the page starts with: ``plan`` and ``notes`` (warnings), or ``picture``."""
    if not source.is_file():
        raise InputError("a plan or a picture of one", "no such file", file=source)
    if is_picture(source):
        return {"picture": _picture(source, metres_per_pixel)}
    house = read_plan(source, house_id, metres_per_pixel)
    return {"plan": house_to_plan(house), "notes": validate_house(house, file=source.name)[:1]}


def is_picture(path: Path) -> bool:
    """Return whether a file begins as a JPEG, PNG, GIF, WebP, TIFF or BMP picture does."""
    with path.open("rb") as file:
        head = file.read(12)
    starts = (b"\x89PNG", b"\xff\xd8\xff", b"GIF8", b"II*\x00", b"MM\x00*", b"BM")
    return head.startswith(starts) or (head[:4] == b"RIFF" and head[8:] == b"WEBP")


def _picture(path: Path, metres_per_pixel: float | None) -> dict[str, Any]:
    """Return a picture as the page holds it: data URL, size in pixels, scale where known."""
    sizes: list[int] = []

    def reduced(image: Any) -> Any:
        sizes.append(max(image.size))
        return to_small_srgb(image, PICTURE_SIDE)

    pixels = decode_image(path, reduced)
    share = max(pixels.shape[:2]) / sizes[0]
    data = base64.b64encode(png_bytes(pixels)).decode("ascii")
    found = {
        "url": f"data:image/png;base64,{data}",
        "width": pixels.shape[1],
        "height": pixels.shape[0],
    }
    return found | ({"metres_per_pixel": metres_per_pixel / share} if metres_per_pixel else {})


def picture_bytes(picture: dict[str, Any]) -> bytes:
    """Return the PNG of a picture that :func:`opened` gave."""
    return base64.b64decode(picture["url"].partition(",")[2])


def editor_page(start: dict[str, Any]) -> str:
    """Return the page's HTML; `start` is ``{house, plan, photos, picture, notes}``."""
    program, style = joined_program("files_page"), (FOLDER / "editor.css").read_text("utf-8")
    policy = (
        f"default-src 'none'; script-src {source_hash(program)}; style-src {source_hash(style)}; "
        "img-src data: blob:; form-action 'none'; base-uri 'none'"
    )
    return Template((FOLDER / "editor.html").read_text("utf-8")).substitute(
        title=html.escape(str(start["house"])),
        policy=policy,
        style=style,
        rules=inline_json(page_rules()),
        start=inline_json(start),
        program=program,
    )


def joined_program(entry: str, folders: Sequence[Path] = (FOLDER,)) -> str:
    """Return a module of the page and all that it imports, found in `folders`, as one module.

    Imports and the word ``export`` are taken out; no two modules have a name in common (a browser
    would say so of the whole).
    """
    texts: dict[str, str] = {}
    needs: dict[str, list[str]] = {}
    queue = [entry]
    while queue:
        name = queue.pop()
        if name not in texts:
            found = (folder / f"{name}.js" for folder in folders)
            text = next(path for path in found if path.is_file()).read_text(encoding="utf-8")
            needs[name] = _IMPORT.findall(text)
            texts[name] = re.sub(r"^export (?=\w)", "", _IMPORT.sub("", text), flags=re.MULTILINE)
            queue += needs[name]
    return "\n".join(texts[name] for name in TopologicalSorter(needs).static_order())


def inline_json(value: object) -> str:
    """Return JSON that stands in a script element: no ``<`` that could end it."""
    return json.dumps(value).replace("<", "\\u003c")


def source_hash(text: str) -> str:
    """Return the source expression of a content policy that allows this text alone."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
