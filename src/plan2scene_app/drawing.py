"""Colours and fonts that all pictures for people share. Pillow is imported late."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from PIL import ImageFont

    from plan2scene.house import House

#: sRGB of a sheet's background and text.
PAPER, INK = (250, 250, 250), (25, 25, 25)


def font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Return Pillow's default font at a size in pixels."""
    from PIL import ImageFont

    return ImageFont.load_default(size=size)


def wide_font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Return the font that matplotlib ships: it has more scripts and a superscript 2."""
    from PIL import ImageFont

    package = find_spec("matplotlib")
    if package is None or not package.submodule_search_locations:
        return ImageFont.load_default(size)
    folder = Path(package.submodule_search_locations[0]) / "mpl-data" / "fonts" / "ttf"
    return ImageFont.truetype(folder / "DejaVuSans.ttf", size)


def font_for(text: str, size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Return Pillow's default font for an ASCII text, else the wide font."""
    return font(size) if text.isascii() else wide_font(size)


def legible(text: str, otherwise: str) -> str:
    """Return a text if the wide font has all its letters, else `otherwise`."""
    if text.isascii():
        return text
    wide = wide_font(16)
    missing = bytes(wide.getmask("\U0010fffd"))
    return otherwise if any(bytes(wide.getmask(c)) == missing for c in text) else text


def room_labels(house: House) -> dict[str, str]:
    """Return the label of each room by id; the id instead if the font lacks a letter of it."""
    return {room: legible(label, room) for room, label in house.labels.items()}
