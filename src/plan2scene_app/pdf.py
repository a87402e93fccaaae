"""Pages of PDF files: how many there are, which have many lines, and their pictures (pypdfium2)."""

from __future__ import annotations

import importlib
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plan2scene.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

    from PIL import Image

#: Most pages that are examined, and pixels of the longer side of a rendered page.
_MAX_PAGES, _PAGE_SIDE = 40, 3000


def is_pdf(path: str | Path) -> bool:
    """Return whether a file is a PDF, by its content."""
    with Path(path).open("rb") as file:
        return file.read(4) == b"%PDF"


def page_count(path: str | Path) -> int:
    """Return the number of pages of a PDF, 1 for a picture."""
    if not is_pdf(path):
        return 1
    with importlib.import_module("pypdfium2").PdfDocument(path) as document:
        return len(document)


def pages_by_lines(path: Any) -> list[int]:
    """Return the numbers, from 1, of a PDF's first 40 pages, those with more vector paths first.

    InputError for a PDF without pages.
    """
    pdfium = importlib.import_module("pypdfium2")
    counts = []
    with pdfium.PdfDocument(path) as document:
        for number in range(min(len(document), _MAX_PAGES)):
            with closing(document[number]) as page:
                kinds = [item.type for item in page.get_objects(max_depth=3)]
            counts.append(kinds.count(pdfium.raw.FPDF_PAGEOBJ_PATH))
    if not counts:
        raise InputError("a PDF with pages", "none")
    return [int(k) + 1 for k in np.argsort(-np.array(counts), kind="stable")]


def page_picture(number: int | None = None) -> Callable[[Any], Image.Image]:
    """Return a function for :func:`plan2scene.images.decode_image` that renders a page of a PDF.

    Without its `number`, from 1, it is the page with the most vector paths.
    """
    return partial(_rendered, number=number)


def _rendered(path: Any, number: int | None) -> Image.Image:
    number = number or pages_by_lines(path)[0]
    with (
        importlib.import_module("pypdfium2").PdfDocument(path) as document,
        closing(document[number - 1]) as page,
    ):
        return page.render(scale=_PAGE_SIDE / max(page.get_size())).to_pil()
