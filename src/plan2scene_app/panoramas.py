"""360-degree photos: find them, and cut them into flat views that the stages read as photos.

A 360-degree photo is equirectangular: columns are headings, rows are angles above the horizon. Its
views share a spot and lens; their EXIF data give the focal length.
"""

from __future__ import annotations

import io
import logging
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import cv2
import numpy as np

from plan2scene.errors import InputError
from plan2scene.images import MAX_PHOTO_PIXELS, decode_image, to_small_srgb
from plan2scene.photos.camera.exif import VIEW_MAKER

_LOG = logging.getLogger("plan2scene")
#: Views of a whole turn; with 90 degrees each, neighbours share a third of what they show.
VIEWS = 6
FOV_DEG = 90.0
#: The views look down, so that they show the floor near the camera, too. Degrees.
PITCH_DEG = -10.0
#: Columns of the panorama that are used: more hardly sharpen a texture of 1 m.
MOST_COLUMNS = 6000
#: Ratio of sides from which a photo that does not tell its angles is no flat one.
WIDE = 2.6
_QUALITY = 95
_ASPECT = 4 / 3
#: Least share of a view that the panorama shows.
_COVERED = 0.98
#: Bytes of a file in which its XMP data are looked for.
_HEAD = 400_000
#: The width from which a picture twice as wide as high may be a panorama without XMP data.
_LEAST_COLUMNS = 1000
#: XMP data of the namespace GPano.
_ANGLES = (
    *(b"FullPanoHeightPixels", b"FullPanoWidthPixels"),
    *(b"CroppedAreaTopPixels", b"CroppedAreaLeftPixels", b"CroppedAreaImageWidthPixels"),
)
#: How much more the outer columns may differ than neighbours do. Spread (standard deviation over
#: that of the picture): at most that of the first row, which shows a single point; at least that of
#: the first column, which shows ceiling and floor, where a drawing shows paper.
_SEAM, _POLE, _EDGE = 2.0, 0.35, 0.1


def cut_panoramas(
    photos: Mapping[str, Path], folder: Path, fov_deg: float = FOV_DEG
) -> dict[str, dict[str, Path]]:
    """Write the views of the 360-degree photos among these files into a folder.

    Return the files of the views by name, for each panorama's name. The views of ``hall.jpg`` are
    ``hall_1.jpg`` and so on; if another photo has such a name, ``hall_view_1.jpg``.
    """
    views: dict[str, dict[str, Path]] = {}
    stems = {Path(name).stem for name in photos}
    for name, path in photos.items():
        try:
            panorama = panorama_of(path)
            files = list(views_of(path, panorama, fov_deg)) if panorama else []
        except InputError:  # whoever reads the photo next says so
            continue
        if files:
            stem = Path(name).stem
            while any(f"{stem}_{number}" in stems for number in range(1, VIEWS + 1)):
                stem += "_view"
            views[name] = {}
            for number, content in enumerate(files, 1):
                view = f"{stem}_{number}.jpg"
                views[name][view] = folder / view
                views[name][view].write_bytes(content)
            _LOG.warning("photo %s: 360 degrees, used as %s", name, ", ".join(views[name]))
    return views


@dataclass(frozen=True)
class Panorama:
    """Where a panorama's picture lies on the whole sphere, in pixels of the picture."""

    whole: tuple[int, int]  #: height and width of the sphere
    top: int = 0
    left: int = 0


def panorama_of(path: Path) -> Panorama | None:
    """Return where a picture file lies on the sphere; None for a flat photo.

    XMP data tell it (GPano). Without them, a picture that is twice as wide as high is one if its
    left edge goes on at its right and its first row shows one point. InputError for a picture that
    cannot be read, and for a wide panorama that does not tell its angles.
    """
    width, height = _size(path)
    with path.open("rb") as file:
        told = _told(file.read(_HEAD), (height, width))
    if told is not None:
        return told
    if width >= _LEAST_COLUMNS and abs(width / height - 2) < 0.01:
        small = _read(path, 512)
        return Panorama((height, width)) if _is_sphere(small) else None
    if max(width, height) >= WIDE * min(width, height):
        expected = f"a photo less than {WIDE:g} times as wide as high"
        raise InputError(expected, "a panorama without angles (GPano)", file=path)
    return None


def _told(head: bytes, size: tuple[int, int]) -> Panorama | None:
    """Return what XMP data at a file's start tell of an equirectangular picture."""
    if not re.search(rb"ProjectionType\W{1,3}equirectangular", head):
        return None
    found = (re.search(rb"%b\W{1,3}(\d{1,6})\b" % name, head) for name in _ANGLES)
    height, width, top, left, part = (int(match[1]) if match else 0 for match in found)
    if not height or not width:
        return Panorama(size)
    zoom = size[1] / (part or width)  # the picture may be reduced since
    return Panorama(
        (round(height * zoom), round(width * zoom)), round(top * zoom), round(left * zoom)
    )


def _is_sphere(image: np.ndarray) -> bool:
    """Return whether an image (h, w, 3) uint8 fits together left and right and has a pole."""
    grey = cv2.GaussianBlur(image, (0, 0), 1).astype(np.float32).mean(2)
    seam = float(np.abs(grey[:, 0] - grey[:, -1]).mean())
    usual = float(np.abs(np.diff(grey, axis=1)).mean())
    pole, edge, whole = (float(part.std()) for part in (grey[0], grey[:, 0], grey))
    return seam <= _SEAM * usual + 1 and pole <= _POLE * whole and edge >= _EDGE * whole


def views_of(path: Path, panorama: Panorama, fov_deg: float = FOV_DEG) -> Iterator[bytes]:
    """Yield JPEG files with flat views of a panorama, 4 to 3, from left to right.

    Views that the picture shows only in part are left out.
    """
    image = _read(path, MOST_COLUMNS)
    zoom = min(1.0, MOST_COLUMNS / image.shape[1])
    if zoom < 1:
        image = cv2.resize(image, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_AREA)
    scale = image.shape[1] / _size(path)[0]
    rows, columns = (side * scale for side in panorama.whole)
    focal = columns / (2 * np.pi)
    width = round(2 * focal * np.tan(np.radians(fov_deg) / 2))
    height = round(width / _ASPECT)
    x, y = np.meshgrid(np.arange(width) - (width - 1) / 2, np.arange(height) - (height - 1) / 2)
    pitch = np.radians(PITCH_DEG)
    forward = focal * np.cos(pitch) + y * np.sin(pitch)
    up = focal * np.sin(pitch) - y * np.cos(pitch)
    heading = np.arctan2(x, forward)
    above = np.arctan2(up, np.hypot(x, forward))
    line = (0.5 - above / np.pi) * rows - panorama.top * scale - 0.5
    around = image.shape[1] >= columns - 1  # the left edge goes on at the right
    for number in range(VIEWS):
        turn = heading + 2 * np.pi * number / VIEWS
        place = (turn / (2 * np.pi) + 0.5) * columns - panorama.left * scale - 0.5
        place = place % columns
        inside = (line >= -1) & (line <= image.shape[0]) & (around | (place < image.shape[1]))
        if inside.mean() < _COVERED:
            continue
        view = _looked_up(image, place, line, around=around)
        yield _jpeg(view, focal)


def _read(path: Path, side: int) -> np.ndarray:
    """Return a picture (h, w, 3) uint8 sRGB; a larger one is reduced to 1 to 4 times `side`."""
    return decode_image(path, partial(to_small_srgb, side=side), max_pixels=MAX_PHOTO_PIXELS)


def _size(path: Path) -> tuple[int, int]:
    """Return the width and height of a picture file of any size, in pixels."""
    return decode_image(path, lambda image: image.size, max_pixels=2**40)


def _looked_up(
    image: np.ndarray, place: np.ndarray, line: np.ndarray, *, around: bool
) -> np.ndarray:
    """Return the pixels (h, w, 3) of an image at columns `place` and rows `line`."""
    margin = 2
    wide = cv2.copyMakeBorder(image, 0, 0, margin, margin, cv2.BORDER_REPLICATE)
    if around:
        wide = cv2.copyMakeBorder(image, 0, 0, margin, margin, cv2.BORDER_WRAP)
    maps = (place + margin).astype(np.float32), line.astype(np.float32)
    return cv2.remap(wide, *maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


def _jpeg(view: np.ndarray, focal_px: float) -> bytes:
    """Return a view (h, w, 3) as JPEG with its focal length in pixels in the EXIF data."""
    from PIL import ExifTags, Image
    from PIL.TiffImagePlugin import IFDRational

    exif = Image.Exif()
    exif[ExifTags.Base.Software] = VIEW_MAKER
    focal_mm = 10
    exif.get_ifd(ExifTags.IFD.Exif).update(
        {
            ExifTags.Base.FocalLength: IFDRational(focal_mm, 1),
            ExifTags.Base.FocalPlaneXResolution: IFDRational(round(100 * focal_px), 1000),
            ExifTags.Base.FocalPlaneResolutionUnit: 4,  # millimetres
            ExifTags.Base.ExifImageWidth: view.shape[1],
            ExifTags.Base.ExifImageHeight: view.shape[0],
        }
    )
    buffer = io.BytesIO()
    Image.fromarray(view).save(buffer, format="JPEG", quality=_QUALITY, exif=exif)
    return buffer.getvalue()
