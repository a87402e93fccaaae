"""Photos that a PDF contains: a listing's brochure has plan and photos in one file."""

from __future__ import annotations

import importlib
import tempfile
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from plan2scene.errors import InputError
from plan2scene.images import MAX_IMAGE_BYTES, MAX_PIXELS

#: Shortest side in pixels of a photo: smaller pictures of a brochure are logos and portraits.
LEAST_SIDE = 300
#: Largest number of pages and of photos that are read.
MOST_PAGES, MOST_PHOTOS = 100, 300
#: How deep a picture may lie in groups of a page's objects.
_DEPTH = 5
_JPEG_QUALITY = 95


def is_pdf(path: Path | None) -> bool:
    """Return whether a path is a PDF, by its content."""
    if path is None or not path.is_file():
        return False
    with path.open("rb") as file:
        return file.read(4) == b"%PDF"


@contextmanager
def unpacked(photos: Path | None) -> Iterator[Path | None]:
    """Yield a folder of photos: a new, temporary one for a PDF, else the path as it is."""
    if photos is None or not is_pdf(photos):
        yield photos
        return
    with tempfile.TemporaryDirectory() as folder:
        if not unpack_photos(photos, Path(folder)):
            raise InputError(f"photos of at least {LEAST_SIDE} pixels a side", "none", file=photos)
        try:
            yield Path(folder)
        except InputError as error:  # of the folder, which the user does not know
            if folder not in str(error):
                raise
            raise InputError(error.expected, error.found, file=photos) from None


def unpack_photos(source: Path, folder: Path) -> list[Path]:
    """Write the pictures of a PDF's pages as ``page01_1.jpg`` and so on; return their paths.

    Small ones are left out, and those of more than `MAX_PIXELS`. InputError for a damaged PDF.
    """
    pdfium = importlib.import_module("pypdfium2")
    written: list[Path] = []
    if source.stat().st_size > MAX_IMAGE_BYTES:
        raise InputError(f"a PDF of at most {MAX_IMAGE_BYTES} bytes", "a larger one", file=source)
    try:
        with pdfium.PdfDocument(source) as document:
            for number in range(min(len(document), MOST_PAGES)):
                with closing(document[number]) as page:
                    pictures = page.get_objects([pdfium.raw.FPDF_PAGEOBJ_IMAGE], max_depth=_DEPTH)
                    for place, picture in enumerate(pictures, start=1):
                        width, height = picture.get_px_size()
                        if min(width, height) < LEAST_SIDE or width * height > MAX_PIXELS:
                            continue
                        if len(written) == MOST_PHOTOS:
                            return written
                        path = folder / f"page{number + 1:02d}_{place}.jpg"
                        image = picture.get_bitmap().to_pil().convert("RGB")
                        image.save(path, quality=_JPEG_QUALITY)
                        written.append(path)
    except pdfium.PdfiumError as error:
        raise InputError("a PDF that can be read", str(error), file=source) from None
    return written
