"""viewer.html: page, style, program and GLB in one file that needs no network."""

from __future__ import annotations

import base64
import html
from pathlib import Path
from string import Template

from plan2scene.errors import InputError
from plan2scene.io import atomic_path

_FOLDER = Path(__file__).parent
#: The program's files, in the order in which they go into the page.
PROGRAM = ("glb.js", "camera.js", "drawing.js", "viewer.js")


def build_viewer(glb: str | Path, output: str | Path, *, house_id: str) -> None:
    """Write the viewer of a house.

    Parameters
    ----------
    glb : path
        The house as :func:`plan2scene.mesh.write_glb` makes it.
    output : path
        An HTML file; it opens from the disk in any browser with WebGL 2.
    house_id : str
        Shown as the title.

    Raises
    ------
    InputError
        When `glb` is no GLB.
    """
    data = Path(glb).read_bytes()
    if data[:4] != b"glTF":
        raise InputError("a GLB file", f"bytes {data[:4]!r}", file=glb, house=house_id)
    template = Template((_FOLDER / "viewer.html").read_text(encoding="utf-8"))
    page = template.substitute(
        title=html.escape(house_id),
        style=(_FOLDER / "viewer.css").read_text(encoding="utf-8"),
        program="\n".join((_FOLDER / name).read_text(encoding="utf-8") for name in PROGRAM),
        glb=base64.b64encode(data).decode("ascii"),
    )
    with atomic_path(output) as temporary:
        temporary.write_text(page, encoding="utf-8")
