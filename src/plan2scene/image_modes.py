"""Pictures as strangers save them: which files are tried, how large, and every mode as sRGB.

Formats outside `FORMATS` are refused: Pillow would hand PostScript to an outside program, and a
camera or a phone writes none of them.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plan2scene.errors import InputError

if TYPE_CHECKING:
    from PIL import Image

#: Images with more pixels are refused before they are decoded (memory of a job stays bounded).
MAX_PIXELS = 50_000_000
#: Image files above this many bytes are refused before they are read.
MAX_IMAGE_BYTES = 200_000_000
#: What Pillow may try; JPEG includes those with a second picture that many phones write (MPO).
FORMATS = ("JPEG", "PNG", "GIF", "WEBP", "TIFF", "BMP", "PPM")
FORMAT_NAMES = "JPEG, PNG, GIF, WebP, TIFF, BMP or PPM"
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


def check_file(path: Path) -> None:
    """Raise InputError for what is no file of a bearable size (folder, pipe, device, too big)."""
    if not path.exists():
        raise InputError("an image", "no such file", file=path)
    if not path.is_file():
        raise InputError("an image", "a folder" if path.is_dir() else "no plain file", file=path)
    size = path.stat().st_size
    if size == 0:
        raise InputError("an image", "an empty file", file=path)
    if size > MAX_IMAGE_BYTES:
        raise InputError(f"an image of at most {MAX_IMAGE_BYTES} bytes", f"{size}", file=path)


def check_size(width: int, height: int) -> None:
    """Raise InputError for a declared size without pixels or with more than `MAX_PIXELS`."""
    if width * height > MAX_PIXELS:
        raise InputError(f"an image of at most {MAX_PIXELS} pixels", f"{width}x{height}")
    if width < 1 or height < 1:
        raise InputError("an image with pixels", f"{width}x{height}")


def kind_of(head: bytes) -> str:
    """Return in words what the first bytes of a file that is no readable image look like."""
    if head[4:8] == b"ftyp":
        brand = head[8:12].decode("ascii", "replace")
        return f"a HEIF or AVIF picture or a video ({brand}); convert it to JPEG"
    signatures = (
        (b"%PDF", "a PDF"),
        (b"%!PS", "PostScript"),
        (b"PK\x03\x04", "a ZIP archive"),
        (b"8BPS", "a Photoshop file"),
        (b"\xff\xd8\xff", "a damaged JPEG"),
        (b"\x89PNG", "a damaged PNG"),
        (b"GIF8", "a damaged GIF"),
        (b"RIFF", "a damaged or unknown RIFF file"),
    )
    for start, name in signatures:
        if head.startswith(start):
            return name
    text = head.lstrip(b"\xef\xbb\xbf \t\r\n").lower()
    if text.startswith((b"<svg", b"<?xml", b"<!doctype svg")):
        return "SVG or XML"
    if text.startswith((b"<!doctype html", b"<html")):
        return "an HTML page"
    if head and all(byte in b"\t\n\r" or byte >= 32 for byte in head):
        return "text"
    return "a file that is none"


def check_webp(head: bytes) -> None:
    """Raise InputError for a WebP whose first 30 bytes declare too large a canvas.

    Pillow allocates the canvas when it opens the file, before it tells the size.
    """
    if head[:4] != b"RIFF" or head[8:12] != b"WEBP" or len(head) < 30:
        return
    kind = head[12:16]
    if kind == b"VP8X":
        width, height = (int.from_bytes(head[k : k + 3], "little") + 1 for k in (24, 27))
    elif kind == b"VP8L":
        bits = int.from_bytes(head[21:25], "little")
        width, height = (bits & 0x3FFF) + 1, (bits >> 14 & 0x3FFF) + 1
    else:
        width, height = (int.from_bytes(head[k : k + 2], "little") & 0x3FFF for k in (26, 28))
    check_size(width, height)


def to_srgb(image: Image.Image) -> np.ndarray:
    """Return a Pillow image of any mode as (h, w, 3) uint8 sRGB, upright, alpha over white.

    The first frame or page; an embedded colour profile is honoured where it can be read, and so
    is the EXIF orientation. Numbers beyond 8 bits are scaled by :func:`_grey_from_numbers`.
    """
    from PIL import Image

    image.load()
    upright = _upright(image)
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


def _upright(image: Image.Image) -> Image.Image:
    """Return an image turned as its EXIF orientation says; as it is where EXIF is damaged."""
    from PIL import Image

    orientation = _or_none(lambda: image.getexif().get(0x0112, 1))
    method = _UPRIGHT.get(orientation) if isinstance(orientation, int) else None
    if method is None:
        return image
    turned = image.transpose(Image.Transpose[method])
    turned.info = image.info
    return turned


def _or_none(attempt: Callable[[], Any]) -> Any:
    """Return what `attempt` gives, or None when the metadata that it parses are damaged."""
    import struct

    try:
        return attempt()
    except (OSError, ValueError, TypeError, LookupError, SyntaxError, struct.error, EOFError):
        return None


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
