"""Pictures of SVG drawings (resvg)."""

from __future__ import annotations

import importlib
import io
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree.ElementTree import Element, tostring

from plan2scene_app.plan_formats.containers import MAX_XML_BYTES, Source, parse_xml

if TYPE_CHECKING:
    from PIL import Image

#: Largest ratio of a drawing's sides.
_MOST_ASPECT = 20.0
#: A length; only the ratio of width and height matters, so its unit does not.
_LENGTH = re.compile(r"\s*([\d.]+(?:e[+-]?\d+)?)\s*(?:px|pt|pc|mm|cm|in|em|ex)?\s*", re.I)


def svg_picture(path: Any, side: int) -> Image.Image:
    """Return the picture of an SVG file on white, its longer side `side` pixels.

    Pictures outside the file are left out. InputError for an SVG without a size.
    """
    from PIL import Image

    content = Path(path).read_bytes()[: MAX_XML_BYTES + 1]
    source = Source(str(path), "")
    root = parse_xml(source, content, doctype=True)
    width, height = _size(source, root)
    for element in root.iter():
        for name in [name for name in element.attrib if name.split("}")[-1] == "href"]:
            if not element.attrib[name].lstrip().startswith(("#", "data:")):
                del element.attrib[name]
    longer = {"width": side} if width >= height else {"height": side}
    try:
        png = importlib.import_module("resvg_py").svg_to_bytes(
            svg_string=tostring(root, encoding="unicode"), background="white", **longer
        )
    except ValueError as error:
        raise source.fault("an SVG that can be drawn", str(error)) from None
    return Image.open(io.BytesIO(bytes(png)), formats=("PNG",))


def _size(source: Source, root: Element) -> tuple[float, float]:
    """Return width and height of a drawing; afterwards only its view box tells them."""
    sides = [_LENGTH.fullmatch(root.attrib.pop(name, "")) for name in ("width", "height")]
    numbers = re.findall(r"[^\s,]+", root.get("viewBox", ""))
    if not numbers and all(sides):
        numbers = ["0", "0", *(side[1] for side in sides if side)]
        root.set("viewBox", " ".join(numbers))
    try:
        _, _, width, height = map(float, numbers)
    except ValueError:
        raise source.fault("an SVG with a size", " ".join(numbers) or "none") from None
    if not 1 / _MOST_ASPECT <= width / max(height, 1e-9) <= _MOST_ASPECT:
        raise source.fault(f"sides of at most 1:{_MOST_ASPECT:g}", f"{width:g} x {height:g}")
    return width, height
