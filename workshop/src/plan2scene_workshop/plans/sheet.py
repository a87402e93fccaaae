"""A sheet to draw on in metres: lines, areas, letters."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import cv2
import numpy as np
import shapely
from numpy.typing import ArrayLike

if TYPE_CHECKING:
    from PIL import ImageFont

_SHIFT = 4
#: Fonts that ship with matplotlib; a stroke font of OpenCV stands for handwriting.
FONTS = {
    "sans": "DejaVuSans.ttf",
    "narrow": "DejaVuSans.ttf",  # compressed to three quarters of its width
    "bold": "DejaVuSans-Bold.ttf",
    "oblique": "DejaVuSans-Oblique.ttf",
    "mono": "DejaVuSansMono.ttf",
    "serif": "STIXGeneral.ttf",
}


class Sheet:
    """A picture (h, w, 3) uint8 of a plan, `ppm` pixels per metre, with its corner at `origin`."""

    def __init__(
        self, size: tuple[int, int], ppm: float, origin: tuple[float, float], colour: Sequence[int]
    ) -> None:
        self.image = np.full((*size, 3), np.array(colour, np.uint8))
        self.ppm, self.origin = ppm, np.array(origin)

    def pixels(self, points: ArrayLike) -> np.ndarray:
        """Return points (n, 2) in metres as fixed-point pixels (n, 1, 2) int32."""
        array = (np.asarray(points, float).reshape(-1, 2) - self.origin) * self.ppm - 0.5
        return np.round(array * (1 << _SHIFT)).astype(np.int32)[:, None]

    def line(
        self,
        points: ArrayLike,
        colour: Sequence[int],
        weight: int = 1,
        *,
        closed: bool = False,
    ) -> None:
        """Draw a polyline."""
        cv2.polylines(
            self.image, [self.pixels(points)], closed, tuple(colour), weight, cv2.LINE_AA, _SHIFT
        )

    def dashes(
        self,
        start: np.ndarray,
        end: np.ndarray,
        colour: Sequence[int],
        weight: int = 1,
        dash: float = 0.1,
    ) -> None:
        """Draw a dashed line with dashes and gaps of `dash` metres."""
        count = max(1, int(np.linalg.norm(end - start) / dash))
        stops = np.linspace(0, 1, count + 1)
        for a, b in zip(stops[:-1:2], stops[1::2], strict=False):
            self.line([start + a * (end - start), start + b * (end - start)], colour, weight)

    def fill(self, points: ArrayLike, colour: Sequence[int]) -> None:
        """Fill a polygon."""
        cv2.fillPoly(self.image, [self.pixels(points)], tuple(colour), cv2.LINE_AA, _SHIFT)

    def fill_shape(self, shape: shapely.Geometry, colour: Sequence[int]) -> None:
        """Fill polygons with their holes."""
        for rings in _rings(shape):
            cv2.fillPoly(
                self.image, [self.pixels(r) for r in rings], tuple(colour), cv2.LINE_AA, _SHIFT
            )

    def outline(self, shape: shapely.Geometry, colour: Sequence[int], weight: int) -> None:
        """Draw the outlines of polygons."""
        for rings in _rings(shape):
            for ring in rings:
                self.line(ring, colour, weight, closed=True)

    def mask(self, shape: shapely.Geometry) -> np.ndarray:
        """Return the mask (h, w) bool of polygons."""
        mask = np.zeros(self.image.shape[:2], np.uint8)
        self.mark(mask, shape, 1)
        return mask > 0

    def mark(self, plane: np.ndarray, shape: shapely.Geometry, value: int) -> None:
        """Set the pixels of polygons in a plane (h, w) uint8 of the sheet's size."""
        for rings in _rings(shape):
            cv2.fillPoly(plane, [self.pixels(r) for r in rings], value, cv2.LINE_8, _SHIFT)

    def window(self, shape: shapely.Geometry) -> tuple[slice, slice]:
        """Return the rows and columns that a shape covers."""
        x0, z0, x1, z1 = shape.bounds
        (a, b), (c, d) = ((np.array([(x0, z0), (x1, z1)]) - self.origin) * self.ppm).astype(int)
        return slice(max(0, b - 1), max(0, d + 2)), slice(max(0, a - 1), max(0, c + 2))

    def write(
        self,
        text: str,
        middle: ArrayLike,
        height: float,
        colour: Sequence[int],
        font: str = "sans",
        *,
        upright: bool = False,
    ) -> tuple[float, float]:
        """Write text, centred on a point; return its size in metres.

        `height` is that of capitals in metres. `upright` text is read from the bottom to the top.
        """
        ink = letters(text, max(5, round(height * self.ppm)), font)
        if upright:
            ink = np.rot90(ink)
        centre = (np.array(middle) - self.origin) * self.ppm
        h, w = ink.shape
        x, y = round(centre[0] - w / 2), round(centre[1] - h / 2)
        x0, y0 = max(0, x), max(0, y)
        x1, y1 = min(self.image.shape[1], x + w), min(self.image.shape[0], y + h)
        if x1 > x0 and y1 > y0:
            part = ink[y0 - y : y1 - y, x0 - x : x1 - x, None]
            below = self.image[y0:y1, x0:x1]
            mixed = below * (1 - part) + np.array(colour, np.float32) * part
            self.image[y0:y1, x0:x1] = mixed.astype(np.uint8)
        return w / self.ppm, h / self.ppm


def _rings(shape: shapely.Geometry) -> list[list[np.ndarray]]:
    """Return the rings of each polygon of a shape."""
    parts = [p for p in shapely.get_parts(shape) if p.geom_type == "Polygon" and not p.is_empty]
    return [
        [np.array(p.exterior.coords)[:-1], *(np.array(r.coords)[:-1] for r in p.interiors)]
        for p in parts
    ]


def letters(text: str, pixels: int, font: str) -> np.ndarray:
    """Return the ink of a line of text, (h, w) float32 in [0, 1]; capitals are `pixels` high."""
    if font == "hand":
        plain = text.encode("ascii", "ignore").decode() or "x"
        scale, weight = pixels / 21.0, max(1, pixels // 9)
        face = cv2.FONT_HERSHEY_SCRIPT_SIMPLEX if len(text) % 3 == 0 else cv2.FONT_HERSHEY_SIMPLEX
        (w, h), base = cv2.getTextSize(plain, face, scale, weight)
        plate = np.zeros((h + base + 4, w + 4), np.uint8)
        cv2.putText(plate, plain, (2, h + 1), face, scale, 255, weight, cv2.LINE_AA)
        return plate.astype(np.float32) / 255
    from PIL import Image, ImageDraw

    type_face = _font(font, max(6, round(pixels * 1.37)))
    left, top, right, bottom = type_face.getbbox(text)
    page = Image.new("L", (int(right - left) + 4, int(bottom - top) + 4))
    ImageDraw.Draw(page).text((2 - left, 2 - top), text, fill=255, font=type_face)
    if font == "narrow":
        page = page.resize((max(1, page.width * 3 // 4), page.height))
    return np.asarray(page, np.float32) / 255


@lru_cache(maxsize=256)
def _font(name: str, size: int) -> ImageFont.FreeTypeFont:
    """Return one of matplotlib's fonts as a Pillow font."""
    import matplotlib
    from PIL import ImageFont

    folder = Path(matplotlib.get_data_path()) / "fonts" / "ttf"
    return ImageFont.truetype(str(folder / FONTS[name]), size)
