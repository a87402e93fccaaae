"""views.jpg: each located photo beside a picture of the house from the same place."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from plan2scene.camera import Camera
from plan2scene.house import House
from plan2scene.images import MAX_PHOTO_PIXELS, decode_image, to_small_srgb
from plan2scene.parallel import each
from plan2scene.photos.locate.pose import Pose
from plan2scene_app.drawing import INK, PAPER, font, font_for, room_labels
from plan2scene_app.pictures.lit_picture import Painter

#: Largest height and width of a picture, pixels.
SIZE = (225, 300)
#: Pairs of photo and house in a row of the sheet.
COLUMNS = 2
_GAP, _TEXT = 8, 22
NONE_LOCATED = "The place of no photo of this house is known."


def photo_view(house: House, pose: Pose) -> Camera:
    """Return a located photo's camera in the house, its picture reduced to fit `SIZE`."""
    x, y, z = pose.position
    lifted = y + house.level_of(pose.room_id).elevation
    camera = replace(pose.camera, position=(x, lifted, z))
    scale = min(SIZE[0] / camera.height, SIZE[1] / camera.width)
    size = max(1, round(camera.height * scale)), max(1, round(camera.width * scale))
    return camera.resized(size)


def render_photo_views(
    house: House,
    photos: Mapping[str, Path],
    poses: Mapping[str, Pose],
    painter: Painter,
    threads: int = 1,
) -> np.ndarray:
    """Return a sheet of pairs, photo and house, by room and name, (h, w, 3) uint8 sRGB.

    Only photos (files by name) that have a pose are drawn, `threads` of them in parallel.
    """
    from PIL import Image, ImageDraw

    order = [room.id for room in house.rooms]
    labels = room_labels(house)
    names = sorted(poses.keys() & photos.keys(), key=lambda n: (order.index(poses[n].room_id), n))
    pairs = list(
        each(lambda n: _pair(photos[n], photo_view(house, poses[n]), painter), names, threads)
    )
    rows = [pairs[k : k + COLUMNS] for k in range(0, len(pairs), COLUMNS)]
    high = [max(len(pair) for pair in row) + _TEXT + _GAP for row in rows] or [_TEXT]
    wide = 2 * SIZE[1] + _GAP
    sheet = Image.new("RGB", (COLUMNS * wide + _GAP, sum(high) + _GAP), PAPER)
    draw = ImageDraw.Draw(sheet)
    for number, (name, pair) in enumerate(zip(names, pairs, strict=True)):
        row, column = divmod(number, COLUMNS)
        left, top = _GAP + column * wide, _GAP + sum(high[:row])
        sheet.paste(Image.fromarray(pair), (left, top))
        text = f"{labels[poses[name].room_id]}: {name}"
        draw.text((left, top + len(pair) + 2), text, fill=INK, font=font_for(text, 13))
    if not names:
        draw.text((_GAP, _GAP), NONE_LOCATED, fill=INK, font=font(15))
    return np.asarray(sheet)


def _pair(path: Path, camera: Camera, painter: Painter) -> np.ndarray:
    """Return a photo and the picture of the house from the same camera, side by side."""
    return np.hstack([_small(path, camera), painter(camera)])


def _small(path: Path, camera: Camera) -> np.ndarray:
    """Return a photo at the size of a camera's picture."""
    side = max(camera.width, camera.height)
    pixels = decode_image(
        path, lambda image: to_small_srgb(image, side), max_pixels=MAX_PHOTO_PIXELS
    )
    return cv2.resize(pixels, (camera.width, camera.height), interpolation=cv2.INTER_AREA)
