"""Focal length of a photo from its EXIF data.

The 35 mm equivalent is defined by the diagonal (CIPA DCG-001): ``focal_px = f35 / 43.27 mm *
diagonal``. This holds for every orientation and after a plain reduction of the photo, but not after
cropping. EXIF data do not record a crop by an editor. The only sign of it is that the pixel
dimensions noted by the camera may have another aspect ratio than the photo has now.
"""

from __future__ import annotations

import logging
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from PIL import ExifTags

from plan2scene.errors import InputError
from plan2scene.images import MAX_PHOTO_PIXELS, decode_image

if TYPE_CHECKING:
    from PIL import Image

Tag = ExifTags.Base
_log = logging.getLogger("plan2scene")
#: Photo formats whose EXIF block Pillow finds without decoding pixels.
FORMATS = ("JPEG", "MPO", "WEBP", "HEIF")
FRAME_DIAGONAL_MM = 43.2666  #: Diagonal of a 36 x 24 mm frame
FOV_RANGE_DEG = (30.0, 120.0)  #: Horizontal fields of view that are accepted, degrees
#: Relative difference of aspect ratios above which a photo counts as cropped.
ASPECT_TOLERANCE = 0.02
#: Software of the flat views that are cut from a 360-degree photo: their focal length is exact.
VIEW_MAKER = "plan2scene views"
#: Millimetres per focal plane resolution unit (inch, centimetre, millimetre).
UNIT_MM = {2: 25.4, 3: 10.0, 4: 1.0}


@dataclass(frozen=True)
class ExifFocal:
    """What a photo's EXIF data say about its focal length."""

    #: Focal length in pixels of the photo at its present size, None when it is unknown or absurd.
    focal_px: float | None = None
    #: The photo's aspect is not the one that the camera noted: `focal_px` may be wrong.
    cropped: bool = False
    warning: str = ""  #: why a given focal length is not used; empty otherwise
    model: str = ""  #: the camera's model; empty when unknown
    #: The focal length is exact or the user gave it: vanishing points do not overrule it.
    told: bool = False


def read_exif_focal(path: str | os.PathLike[str], size: tuple[int, int]) -> ExifFocal:
    """Return the focal length that the EXIF data of a photo file give; pixels are not decoded.

    `size` is height and width in pixels, orientation applied or not. Never raises: a file without
    readable EXIF data gives no focal length. ``FocalLengthIn35mmFilm`` is used if present, else
    ``FocalLength`` with ``FocalPlaneXResolution``. A field of view (along the given width) outside
    `FOV_RANGE_DEG` is refused with a warning.
    """
    tags = _tags(path)
    height, width = size
    noted = [_number(tags.get(tag)) for tag in (Tag.ExifImageWidth, Tag.ExifImageHeight)]
    equivalent = _number(tags.get(Tag.FocalLengthIn35mmFilm))
    if equivalent > 0:
        focal = equivalent / FRAME_DIAGONAL_MM * float(np.hypot(width, height))
        text = f"35 mm equivalent focal length {equivalent:g} mm"
    else:
        focal = _focal_of_sensor(tags, noted, size)
        text = f"focal length {_number(tags.get(Tag.FocalLength)):g} mm"
    model = str(tags.get(Tag.Model) or "").strip()
    if focal <= 0:
        return ExifFocal(model=model)
    fov = float(np.degrees(2 * np.arctan(width / 2 / focal)))
    if not FOV_RANGE_DEG[0] <= fov <= FOV_RANGE_DEG[1]:
        return ExifFocal(
            warning=f"EXIF {text} not used: {fov:.0f} degrees wide, expected "
            f"{FOV_RANGE_DEG[0]:.0f} to {FOV_RANGE_DEG[1]:.0f}",
            model=model,
        )
    exact = tags.get(Tag.Software) == VIEW_MAKER
    return ExifFocal(focal, _is_cropped(noted, size), model=model, told=exact)


def _tags(path: str | os.PathLike[str]) -> dict[int, Any]:
    """Return the tags of the Exif block; empty without a readable one."""
    try:
        return decode_image(path, _exif_block, max_pixels=MAX_PHOTO_PIXELS)
    except InputError as error:
        _log.debug("no EXIF data: %s", error)
        return {}


def _exif_block(image: Image.Image) -> dict[int, Any]:
    if image.format not in FORMATS:
        return {}
    tags = image.getexif()
    named = {tag: tags.get(tag) for tag in (Tag.Model, Tag.Software)}
    return tags.get_ifd(ExifTags.IFD.Exif) | named


def _number(value: Any) -> float:
    """Return the value of a tag as a positive float; 0 when it is not a finite positive number."""
    try:
        number = float(value)
    except (TypeError, ValueError, ZeroDivisionError, OverflowError):
        return 0.0
    return number if np.isfinite(number) and number > 0 else 0.0


def _focal_of_sensor(tags: dict[int, Any], noted: list[float], size: tuple[int, int]) -> float:
    """Return the focal length in pixels from the sensor's pixel pitch, 0 when unknown.

    The pitch refers to the pixels of the original photo. The photo may be reduced since, so the
    pixel dimensions noted by the camera are needed as well.
    """
    unit = UNIT_MM.get(tags.get(Tag.FocalPlaneResolutionUnit, 2))
    focal, density = (_number(tags.get(t)) for t in (Tag.FocalLength, Tag.FocalPlaneXResolution))
    if unit is None or min(noted) <= 0 or focal <= 0 or density <= 0:
        return 0.0
    return focal * density / unit * max(size) / max(noted)


def _is_cropped(noted: list[float], size: tuple[int, int]) -> bool:
    """Tell whether the photo's aspect ratio differs from the noted one, in either orientation."""
    if min(noted) <= 0 or min(size) <= 0:
        return False
    before, now = max(noted) / min(noted), max(size) / min(size)
    return abs(before / now - 1.0) > ASPECT_TOLERANCE
