"""What pictures for people share: colours and the font of their text. Pillow is imported late."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from PIL import ImageFont

#: sRGB of a sheet's background and text.
PAPER, INK = (250, 250, 250), (25, 25, 25)


def font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Return Pillow's own font at a size in pixels."""
    from PIL import ImageFont

    return ImageFont.load_default(size=size)
