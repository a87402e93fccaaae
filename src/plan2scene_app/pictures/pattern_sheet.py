"""patterns.jpg: each floor as a photo shows it, with the detected joints, and the laid floor."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from plan2scene.house import House, SurfaceKey
from plan2scene.images import image_from_bytes
from plan2scene.io import read_parquet
from plan2scene.photos.patterns.units import UNITS
from plan2scene.plans.surface_areas import Area
from plan2scene.textures.laying import LaidPattern, laid, read_patterns
from plan2scene_app.drawing import INK, PAPER, font, font_for, room_labels

_GAP, _TEXT = 10, 24
_WIDE = round(UNITS.shown_m * UNITS.shown_px_per_m)
_COLUMNS = 2
NO_FLOORS = "No photo of this house shows a floor largely enough."


def draw_patterns(house: House, patterns: str | Path | None) -> np.ndarray:
    """Return a sheet with a pair of pictures for each floor in `patterns`, (h, w, 3) uint8 sRGB.

    The left picture is a rectified photo of the floor with the detected joints. The right one is
    the laid floor at the same scale, in the same direction and colour. `patterns` is the path of
    ``patterns.parquet``, None if no photo was read.
    """
    from PIL import Image, ImageDraw

    if patterns is None:
        table, by_floor = [], {}
    else:
        table = [row for row in read_parquet(patterns)[0].itertuples() if len(row.shown)]
        by_floor = read_patterns(patterns)
    labels = room_labels(house)
    floors: dict[bytes, list] = {}
    for row in table:
        floors.setdefault(row.shown, []).append(row)
    high, wide = _WIDE + 2 * _TEXT + _GAP, 2 * _WIDE + 2 * _GAP
    lines = max(1, -(-len(floors) // _COLUMNS))
    sheet = Image.new("RGB", (_COLUMNS * wide + _GAP, lines * high + _GAP), PAPER)
    draw = ImageDraw.Draw(sheet)
    for number, (picture, rows) in enumerate(floors.items()):
        line, column = divmod(number, _COLUMNS)
        top, left = _GAP + line * high, _GAP + column * wide
        photo = image_from_bytes(picture)
        pattern = by_floor.get(SurfaceKey(rows[0].room_id, rows[0].surface))
        pattern = pattern if pattern and pattern.units else None
        for k, part in enumerate((photo, _floor(pattern, photo))):
            if part is not None:
                sheet.paste(Image.fromarray(part), (left + k * (_WIDE + _GAP // 2), top))
        names = ", ".join(labels[row.room_id] for row in rows)
        for k, text in enumerate((names, _words(rows[0], pattern))):
            place = left, top + _WIDE + 2 + k * (_TEXT - 4)
            draw.text(place, text, fill=INK, font=font_for(text, 14))
    if not floors:
        draw.text((_GAP, _GAP), NO_FLOORS, fill=INK, font=font(15))
    return np.asarray(sheet)


def _floor(pattern: LaidPattern | None, photo: np.ndarray) -> np.ndarray | None:
    """Return the laid floor at a photo's size (h, w, 3), rows along x, in the photo's colour."""
    if pattern is None:
        return None
    high, wide = (side / UNITS.shown_px_per_m for side in photo.shape[:2])
    # Use the least magenta pixels: lines drawn over the photo, and their JPEG blur, are magenta.
    floor_pixels = photo[photo.any(axis=2)].astype(int)
    magenta = np.minimum(floor_pixels[:, 0], floor_pixels[:, 2]) - floor_pixels[:, 1]
    colour = np.median(floor_pixels[magenta <= np.percentile(magenta, 40)], axis=0) / 255.0
    upright = replace(pattern, direction_deg=0.0)
    image, _ = laid(upright, Area((0.0, 0.0), (wide, high)), colour, 0)
    return cv2.resize(image, photo.shape[1::-1], interpolation=cv2.INTER_AREA)


def _words(row: Any, pattern: LaidPattern | None) -> str:
    """Return a line of text with what was detected on a floor."""
    size = f" {100 * row.width_m:.1f} x {100 * row.length_m:.1f} cm" if row.width_m > 0 else ""
    size = size.replace(" x nan cm", " cm wide")
    count = "not laid" if pattern is None else f"{len(pattern.units)} units"
    kind = "no joints to be seen" if row.kind == "plain" and row.confidence < 0.5 else row.kind
    return f"{kind}{size}, confidence {row.confidence:.2f}, {count}"
