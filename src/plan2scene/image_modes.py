"""Pictures of every mode as upright 8-bit sRGB."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from PIL import Image

_MAX_ICC_BYTES = 4_000_000
_BAND_ROWS = 256
#: EXIF orientation -> Pillow's transposition that makes the picture upright.
_UPRIGHT = {
    2: "FLIP_LEFT_RIGHT",
    3: "ROTATE_180",
    4: "FLIP_TOP_BOTTOM",
    5: "TRANSPOSE",
    6: "ROTATE_270",
    7: "TRANSVERSE",
    8: "ROTATE_90",
}


def to_srgb(image: Image.Image) -> np.ndarray:
    """Return a Pillow image of any mode as (h, w, 3) uint8 sRGB, upright, alpha over white.

    The first frame or page; an embedded colour profile is honoured where it can be read, and so
    is the EXIF orientation. Numbers beyond 8 bits are scaled by :func:`_grey_from_numbers`.
    """
    image.load()
    return _srgb(image, _orientation(image))


def to_small_srgb(image: Image.Image, side: int) -> np.ndarray:
    """Return :func:`to_srgb` of an image reduced to a longer side between `side` and thrice it.

    JPEG is decoded at an eighth, a quarter or half of its size; others are averaged over squares
    of pixels, scans in black and white or by a palette as greys and colours, before anything else
    is made of them. ValueError for other modes.
    """
    orientation = _orientation(image)
    longer = max(image.size)
    image.draft(None, (max(1, image.width * side // longer), max(1, image.height * side // longer)))
    image.load()
    factor = max(1, max(image.size) // (2 * side))
    if factor == 1:
        return _srgb(image, orientation)
    check_reducible(image)
    info = dict(image.info)
    if image.mode in ("1", "P"):
        to = "L" if image.mode == "1" else "RGBA" if "transparency" in info else "RGB"
        image = image.convert(to)
        info.pop("transparency", None)
    small = image.reduce(factor)
    small.info = info
    return _srgb(small, orientation)


def check_reducible(image: Image.Image) -> None:
    """Raise ValueError for an opened image of a mode that is not reduced while it is decoded."""
    if image.mode not in ("RGB", "RGBA", "L", "LA", "CMYK", "1", "P"):
        raise ValueError(f"mode {image.mode} of so many pixels")


def _srgb(image: Image.Image, orientation: int) -> np.ndarray:
    """Return an image as (h, w, 3) uint8 sRGB, turned as an EXIF orientation says."""
    from PIL import Image

    upright = _turned(image, orientation)
    if upright.mode in ("I", "F") or upright.mode.startswith("I;16"):
        grey = _grey_from_numbers(np.asarray(upright))
        return np.ascontiguousarray(np.repeat(grey[..., None], 3, axis=2))
    alpha = None
    if upright.mode in ("RGBA", "LA", "PA", "La", "RGBa") or "transparency" in upright.info:
        upright = upright.convert("RGBA")
        alpha = upright.getchannel("A")
    colour = _profiled(upright, image.info.get("icc_profile"))
    if alpha is not None:
        white = Image.new("RGB", colour.size, (255, 255, 255))
        white.paste(colour, mask=alpha)
        colour = white
    # In bands: the whole picture at once would be held three times over.
    pixels = np.empty((colour.height, colour.width, 3), np.uint8)
    for top in range(0, colour.height, _BAND_ROWS):
        band = (0, top, colour.width, min(top + _BAND_ROWS, colour.height))
        pixels[top : top + _BAND_ROWS] = np.asarray(colour.crop(band))
    return pixels


def _orientation(image: Image.Image) -> int:
    """Return an image's EXIF orientation; 1 where it has none or EXIF is damaged."""
    import struct

    try:
        found = image.getexif().get(0x0112, 1)
    except (OSError, ValueError, TypeError, LookupError, SyntaxError, struct.error, EOFError):
        return 1
    return found if isinstance(found, int) else 1


def _turned(image: Image.Image, orientation: int) -> Image.Image:
    """Return an image made upright from an EXIF orientation."""
    from PIL import Image

    method = _UPRIGHT.get(orientation)
    if method is None:
        return image
    turned = image.transpose(Image.Transpose[method])
    turned.info = image.info
    return turned


def _grey_from_numbers(values: np.ndarray) -> np.ndarray:
    """Return (h, w) uint8 grey of 16-bit, 32-bit or float numbers.

    White is 65535 in 16-bit images. In the others it is the least of 1 (floats only), 255,
    65535 that no pixel exceeds, else the largest value. What is no number is black.
    """
    if values.dtype.kind in "ui" and values.dtype.itemsize == 2:
        steps = (np.arange(65536, dtype=np.uint32) * 255 + 32767) // 65535
        return np.asarray(steps.astype(np.uint8)[values])
    numbers = np.nan_to_num(values.astype(np.float32), copy=False, posinf=0.0, neginf=0.0)
    largest = float(numbers.max(initial=0.0))
    whites = (1.0, 255.0, 65535.0) if values.dtype.kind == "f" else (255.0, 65535.0)
    white = next((white for white in whites if largest <= white), largest)
    numbers *= 255.0 / white
    return np.asarray(np.clip(np.rint(numbers), 0, 255).astype(np.uint8))


def _profiled(image: Image.Image, profile: object) -> Image.Image:
    """Return an image as RGB; by its ICC profile when it has a sound one that is not sRGB."""
    if image.mode not in ("RGB", "L", "CMYK"):
        image = image.convert("RGB")
    if isinstance(profile, bytes) and 128 <= len(profile) <= _MAX_ICC_BYTES:
        converted = _by_profile(image, profile)
        if converted is not None:
            return converted
    return image if image.mode == "RGB" else image.convert("RGB")


def _by_profile(image: Image.Image, profile: bytes) -> Image.Image | None:
    """Return an image converted to sRGB; None when its profile is sRGB, damaged, or of others."""
    from PIL import ImageCms

    try:
        source = ImageCms.ImageCmsProfile(io.BytesIO(profile))
        if "srgb" in ImageCms.getProfileDescription(source).lower():
            return None
        target = ImageCms.createProfile("sRGB")
        return ImageCms.profileToProfile(image, source, target, outputMode="RGB")
    except (ImageCms.PyCMSError, OSError, ValueError, TypeError):
        return None
