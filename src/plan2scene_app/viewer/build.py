"""viewer.html: page, style, three.js, program and GLB in one file that needs no network."""

from __future__ import annotations

import base64
import gzip
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from plan2scene.errors import InputError
from plan2scene.html_page import html_page, inline_json, source_hash
from plan2scene.io import atomic_path

_FOLDER = Path(__file__).parent
#: The program's files, in the order in which they go into the page.
PROGRAM = ("house.js", "light.js", "eye.js", "sight.js", "walk.js", "tools.js", "viewer.js")
#: What the page says of a house of which only the GLB is known.
NO_FACTS: Mapping[str, Any] = {"surfaces": {}, "photos": []}


def build_viewer(
    glb: str | Path,
    output: str | Path,
    *,
    house_id: str,
    facts: Mapping[str, Any] = NO_FACTS,
) -> None:
    """Write the viewer of a house.

    The page's content policy lets the two scripts and the style run that are written here, by their
    hashes, and no request. Names are escaped; the program shows them as text.

    Parameters
    ----------
    glb : path
        The house as :func:`plan2scene.mesh.write_glb` makes it.
    output : path
        An HTML file; it opens from the disk in any browser with WebGL 2.
    house_id : str
        Shown as the title.
    facts : mapping
        What a click tells beside the GLB, see :func:`plan2scene_app.viewer.facts.read_facts`.

    Raises
    ------
    InputError
        When `glb` is no GLB.
    """
    data = Path(glb).read_bytes()
    if data[:4] != b"glTF":
        raise InputError("a GLB file", f"bytes {data[:4]!r}", file=glb, house=house_id)
    style = _text("viewer.css")
    library = _text("three.min.js")
    program = "\n".join(_text(name) for name in PROGRAM)
    scripts = f"{source_hash(library)} {source_hash(program)}"
    policy = (
        f"default-src 'none'; script-src {scripts}; style-src {source_hash(style)}; "
        "img-src data: blob:; base-uri 'none'; form-action 'none'"
    )
    page = html_page(
        _FOLDER / "viewer.html",
        title=house_id,
        style=style,
        policy=policy,
        library=library,
        program=program,
        facts=inline_json(facts),
        glb=base64.b64encode(gzip.compress(data, 9, mtime=0)).decode("ascii"),
    )
    with atomic_path(output) as temporary:
        temporary.write_text(page, encoding="utf-8")


def _text(name: str) -> str:
    """Return a file of this package."""
    return (_FOLDER / name).read_text(encoding="utf-8")
