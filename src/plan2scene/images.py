"""Pictures: which image files are accepted, how they are read, and how our own are written.

Pixels are (h, w, 3) uint8 sRGB; pictures of every mode become upright 8-bit sRGB. Pillow is
imported by the functions that need it.
"""

from __future__ import annotations

import importlib
import io
import os
import re
import struct
import warnings
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from plan2scene.errors import InputError
from plan2scene.io import absent, atomic_path

if TYPE_CHECKING:
    from PIL import Image

_MAX_ICC_BYTES = 4_000_000
_BAND_ROWS = 256
#: Errors that damaged EXIF data cause in Pillow.
_DAMAGED_EXIF = (
    ArithmeticError,
    AttributeError,
    EOFError,
    LookupError,
    OSError,
    SyntaxError,
    TypeError,
    ValueError,
    struct.error,
)


def to_srgb(image: Image.Image) -> np.ndarray:
    """Return a Pillow image of any mode as (h, w, 3) uint8 sRGB, upright, alpha over white.

    Only the first frame or page is read. A readable colour profile and the EXIF orientation are
    applied. Pixels of more than 8 bits are scaled by :func:`_grey_from_numbers`.
    """
    image.load()
    return _srgb(image)


def to_small_srgb(image: Image.Image, side: int) -> np.ndarray:
    """Return :func:`to_srgb` of a large image, its longer side reduced to 1 to 4 times `side`.

    A JPEG is decoded at an eighth, a quarter or half of its size. Then, to save memory, any image
    is averaged over squares of pixels before other steps; for this, black-and-white and palette
    images become grey or colour. ValueError for a mode that cannot be averaged.
    """
    longer = max(image.size)
    image.draft(None, (max(1, image.width * side // longer), max(1, image.height * side // longer)))
    image.load()  # this turns a TIFF upright
    factor = max(1, max(image.size) // (2 * side))
    if factor == 1:
        return _srgb(image)
    check_reducible(image)
    info = dict(image.info)
    if image.mode in ("1", "P"):
        to = "L" if image.mode == "1" else "RGBA" if "transparency" in info else "RGB"
        image = image.convert(to)
        info.pop("transparency", None)
    small = image.reduce(factor)
    small.info = info
    return _srgb(small)


def check_reducible(image: Image.Image) -> None:
    """Raise ValueError for an image whose mode :func:`to_small_srgb` cannot reduce."""
    if image.mode not in ("RGB", "RGBA", "L", "LA", "CMYK", "1", "P"):
        raise ValueError(f"mode {image.mode} of so many pixels")


def _srgb(image: Image.Image) -> np.ndarray:
    """Return a loaded image as (h, w, 3) uint8 sRGB, upright; it is turned in place."""
    from PIL import Image

    _turn_upright(image)
    if image.mode in ("I", "F") or image.mode.startswith("I;16"):
        grey = _grey_from_numbers(np.asarray(image))
        return np.ascontiguousarray(np.repeat(grey[..., None], 3, axis=2))
    profile, alpha = image.info.get("icc_profile"), None
    if image.mode in ("RGBA", "LA", "PA", "La", "RGBa") or "transparency" in image.info:
        image = image.convert("RGBA")
        alpha = image.getchannel("A")
    colour = _profiled(image, profile)
    if alpha is not None:
        white = Image.new("RGB", colour.size, (255, 255, 255))
        white.paste(colour, mask=alpha)
        colour = white
    # In bands: converting the whole picture at once would need its memory three times.
    pixels = np.empty((colour.height, colour.width, 3), np.uint8)
    for top in range(0, colour.height, _BAND_ROWS):
        band = (0, top, colour.width, min(top + _BAND_ROWS, colour.height))
        pixels[top : top + _BAND_ROWS] = np.asarray(colour.crop(band))
    return pixels


def _turn_upright(image: Image.Image) -> None:
    """Turn a loaded image in place as its EXIF orientation says; damaged EXIF is ignored."""
    from PIL import ImageOps

    with suppress(*_DAMAGED_EXIF):
        ImageOps.exif_transpose(image, in_place=True)


def _grey_from_numbers(values: np.ndarray) -> np.ndarray:
    """Return (h, w) uint8 grey of 16-bit, 32-bit or float numbers.

    White is 65535 in 16-bit images. In the others it is the smallest of 1 (floats only), 255 and
    65535 that no pixel exceeds, else the largest pixel. NaN and infinity become black.
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
    """Return an image as RGB, converted by its ICC profile if that is valid and not sRGB."""
    if image.mode not in ("RGB", "L", "CMYK"):
        image = image.convert("RGB")
    if isinstance(profile, bytes) and 128 <= len(profile) <= _MAX_ICC_BYTES:
        converted = _by_profile(image, profile)
        if converted is not None:
            return converted
    return image if image.mode == "RGB" else image.convert("RGB")


def _by_profile(image: Image.Image, profile: bytes) -> Image.Image | None:
    """Return an image converted to sRGB; None if its profile is sRGB, damaged or unfit."""
    from PIL import ImageCms

    try:
        source = ImageCms.ImageCmsProfile(io.BytesIO(profile))
        if "srgb" in ImageCms.getProfileDescription(source).lower():
            return None
        target = ImageCms.createProfile("sRGB")
        return ImageCms.profileToProfile(image, source, target, outputMode="RGB")
    except (ImageCms.PyCMSError, OSError, ValueError, TypeError):
        return None


_Decoded = TypeVar("_Decoded")
#: Images with more pixels are refused before they are decoded, which bounds a job's memory.
MAX_PIXELS = 50_000_000
#: Most pixels of a photo; one with more than `MAX_PIXELS` is reduced while it is decoded.
MAX_PHOTO_PIXELS = 150_000_000
MAX_IMAGE_BYTES = 200_000_000  #: Image files above this many bytes are refused before they are read
#: Formats that Pillow may read; JPEG includes MPO, a JPEG with a second picture, as many phones
#: write it. Others are refused: for PostScript, Pillow would start another program.
FORMATS = ("JPEG", "PNG", "GIF", "WEBP", "TIFF", "BMP", "PPM")
FORMAT_NAMES = "JPEG, PNG, GIF, WebP, TIFF, BMP, PPM, HEIC or AVIF"
#: File endings of pictures, to recognise a picture before it is read (when jobs are planned).
SUFFIXES = (
    *(".png", ".jpg", ".jpeg", ".gif", ".webp", ".tif", ".tiff", ".bmp", ".ppm"),
    *(".heic", ".heif", ".hif", ".avif", ".pdf"),
)
#: Brands of HEIF files with HEVC pictures, as phones write them.
_HEIF_BRANDS = (b"heic", b"heix", b"heim", b"heis", b"mif1", b"msf1", b"hevc", b"hevx")
_AVIF_BRANDS = (b"avif", b"avis")
METRIC_SIZE = 128  #: Side in pixels at which the paper compares textures


def read_image(path: str | os.PathLike[str], *, house_id: str = "") -> np.ndarray:
    """Return an image as (h, w, 3) uint8 sRGB, EXIF orientation applied, alpha over white.

    Every mode is converted (palette, CMYK, grey, 16 bit, float) and a colour profile is applied.
    Of an animation or a file with pages, the first is read. Raises InputError for a file that is
    not of `FORMATS`, HEIC or AVIF, is truncated, or has more than `MAX_PIXELS` pixels or
    `MAX_IMAGE_BYTES` bytes; these limits are checked before decoding.
    """
    return decode_image(path, to_srgb, house_id=house_id)


def read_reduced_image(
    path: str | os.PathLike[str],
    side: int,
    *,
    house_id: str = "",
    page_of: Callable[[Any], Image.Image] | None = None,
) -> tuple[np.ndarray, tuple[int, int]]:
    """Return an image as :func:`read_image` does, and the (height, width) of its file.

    `page_of` makes it read a PDF or an SVG too (:func:`decode_image`). An image with more than
    `MAX_PIXELS` and up to `MAX_PHOTO_PIXELS` pixels is reduced, its longer side not below `side`:
    this takes the memory of a picture of the reduced size, or about 1 GB.
    """

    def reduced(image: Image.Image) -> tuple[np.ndarray, tuple[int, int]]:
        width, height = image.size
        large = width * height > MAX_PIXELS
        pixels = to_small_srgb(image, side) if large else to_srgb(image)
        turned = (pixels.shape[0] > pixels.shape[1]) != (height > width)
        return pixels, (width, height) if turned else (height, width)

    return decode_image(
        path, reduced, house_id=house_id, max_pixels=MAX_PHOTO_PIXELS, page_of=page_of
    )


def decode_image(
    source: str | os.PathLike[str] | io.BytesIO,
    decode: Callable[[Image.Image], _Decoded],
    *,
    house_id: str = "",
    max_pixels: int = MAX_PIXELS,
    page_of: Callable[[Any], Image.Image] | None = None,
) -> _Decoded:
    """Open an image with Pillow and return `decode` of it; any failure becomes an InputError.

    A PDF or an SVG is accepted too where `page_of` returns the picture of a page, given its path.
    """
    from PIL import Image, UnidentifiedImageError, features

    file, head = ("" if isinstance(source, io.BytesIO) else source), b""
    fault = partial(InputError, file=file, house=house_id)
    try:
        if not isinstance(source, io.BytesIO):
            _check_file(Path(source))
            with Path(source).open("rb") as stream:
                head = stream.read(64)
            _check_webp(head, max_pixels)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            if page_of and _kind_of(head) in _PAGES:
                return decode(page_of(source))
            formats: tuple[str, ...] = FORMATS
            if head[4:8] == b"ftyp" and head[8:12] in _HEIF_BRANDS:
                importlib.import_module("pillow_heif").register_heif_opener(thumbnails=False)
                formats = ("HEIF",)
            if head[4:8] == b"ftyp" and head[8:12] in _AVIF_BRANDS and features.check("avif"):
                formats = ("AVIF",)
            with Image.open(source, formats=formats) as image:
                _check_size(*image.size, max_pixels)
                return decode(image)
    except InputError as error:
        raise fault(error.expected, error.found) from None
    except UnidentifiedImageError:
        raise fault(f"an image ({FORMAT_NAMES})", _kind_of(head)) from None
    except Image.DecompressionBombError as error:  # Pillow's own limit; the size is not known yet
        count = re.search(r"\d+", str(error))
        found = count[0] if count else "more"
        raise fault(f"an image of at most {max_pixels} pixels", found) from None
    except Exception as error:  # decoders raise many types of error on damaged data
        raise fault("an image that decodes", f"{type(error).__name__}: {error}") from None


def _check_file(path: Path) -> None:
    """Raise InputError if a path is no plain file (folder, pipe, device), empty or too large."""
    if not path.exists():
        raise InputError("an image", absent(path), file=path)
    if not path.is_file():
        raise InputError("an image", "a folder" if path.is_dir() else "no plain file", file=path)
    size = path.stat().st_size
    if size == 0:
        raise InputError("an image", "an empty file", file=path)
    if size > MAX_IMAGE_BYTES:
        raise InputError(f"an image of at most {MAX_IMAGE_BYTES} bytes", f"{size}", file=path)


def _check_size(width: int, height: int, most: int) -> None:
    """Raise InputError for a declared size of no pixels or of more than `most`."""
    if width * height > most:
        raise InputError(f"an image of at most {most} pixels", f"{width}x{height}")
    if width < 1 or height < 1:
        raise InputError("an image with pixels", f"{width}x{height}")


_PAGES = ("a PDF", "SVG or XML")


def _kind_of(head: bytes) -> str:
    """Say in words what an unreadable image file is, judged by its first bytes."""
    if head[4:8] == b"ftyp":
        brand = head[8:12].decode("ascii", "replace")
        return f"a damaged HEIC or AVIF picture or a video ({brand}); convert it to JPEG"
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


def _check_webp(head: bytes, most: int) -> None:
    """Raise InputError for a WebP whose first 30 bytes declare too large a canvas.

    Pillow allocates the canvas when it opens the file, before the size can be checked.
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
    _check_size(width, height, most)


def image_from_bytes(data: bytes) -> np.ndarray:
    """Return PNG or JPEG bytes as (h, w, 3) uint8 sRGB."""
    return decode_image(io.BytesIO(data), to_srgb)


def png_bytes(image: np.ndarray) -> bytes:
    """Return a (h, w, 3) or (h, w) uint8 image as PNG bytes (same bytes for same pixels)."""
    from PIL import Image

    buffer = io.BytesIO()
    Image.fromarray(image).save(buffer, format="PNG", compress_level=4)
    return buffer.getvalue()


def jpeg_bytes(image: np.ndarray, *, quality: int, full_colour: bool = False) -> bytes:
    """Return a (h, w, 3) uint8 sRGB image as JPEG; `full_colour`: without chroma subsampling."""
    from PIL import Image

    buffer = io.BytesIO()
    way = 0 if full_colour else 2
    Image.fromarray(image).save(buffer, format="JPEG", quality=quality, subsampling=way)
    return buffer.getvalue()


def write_png(path: str | os.PathLike[str], image: np.ndarray) -> None:
    """Write a (h, w, 3) sRGB or (h, w) grey uint8 image as PNG, atomically."""
    with atomic_path(path) as temporary:
        temporary.write_bytes(png_bytes(image))


def metric_image(image: np.ndarray) -> np.ndarray:
    """Return a (h, w, 3) uint8 sRGB image at the metrics' 128x128 px (area-averaged if larger)."""
    if image.shape[:2] == (METRIC_SIZE, METRIC_SIZE):
        return image
    from PIL import Image

    picture = Image.fromarray(image).resize((METRIC_SIZE, METRIC_SIZE), Image.Resampling.BOX)
    return np.asarray(picture)


def window_counts(mask: np.ndarray, height: int, width: int) -> np.ndarray:
    """Return how many pixels of a mask (h, w) bool each window of `height` x `width` px holds.

    The windows lie within the mask: (h - height + 1, w - width + 1) float32, by top left pixel.
    """
    import cv2

    pixels, size = mask.astype(np.uint8), (width, height)
    counts = cv2.boxFilter(pixels, cv2.CV_32F, size, anchor=(0, 0), normalize=False)
    return counts[: len(mask) - height + 1, : mask.shape[1] - width + 1]


def medoid_index(images: Sequence[np.ndarray]) -> int:
    """Return the index of the image closest (L2) to the mean RGB image (paper, reference crop).

    Images are (h, w, 3) uint8 of one size. Of equally close ones it is the first.
    """
    stack = np.stack([image.astype(np.float64) for image in images])
    distance = ((stack - stack.mean(axis=0)) ** 2).reshape(len(stack), -1).sum(axis=1)
    return int(np.argmin(distance))
