"""Pages of PDF files: how many there are, which have many lines, and their pictures (pypdfium2).

An SVG drawing counts as a file with one page.
"""

from __future__ import annotations

import importlib
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plan2scene.errors import InputError
from plan2scene_app.svg import svg_picture

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from PIL import Image

#: Most pages that are examined, and pixels of the longer side of a rendered page.
_MAX_PAGES, PAGE_SIDE = 40, 3000
#: Most pieces of text of a page that are read, and the gap between two words over their height.
_MAX_TEXTS, _SPACE = 3000, 0.12


def is_pdf(path: str | Path) -> bool:
    """Return whether a path is a PDF file, by its content."""
    if not Path(path).is_file():
        return False
    with Path(path).open("rb") as file:
        return file.read(4) == b"%PDF"


@contextmanager
def opened(path: Any) -> Iterator[Any]:
    """Yield the pypdfium2 document of a file; InputError for a damaged or a locked one."""
    pdfium = importlib.import_module("pypdfium2")
    try:
        with pdfium.PdfDocument(path) as document:
            yield document
    except pdfium.PdfiumError as error:
        raise InputError("a PDF that can be read", str(error), file=path) from None


def page_count(path: str | Path) -> int:
    """Return the number of pages of a PDF, 1 for a picture."""
    if not is_pdf(path):
        return 1
    with opened(path) as document:
        return len(document)


def pages_by_lines(path: Any) -> list[int]:
    """Return the numbers, from 1, of a PDF's first 40 pages, those with more vector paths first.

    InputError for a PDF without pages.
    """
    pdfium = importlib.import_module("pypdfium2")
    counts = []
    with opened(path) as document:
        for number in range(min(len(document), _MAX_PAGES)):
            with closing(document[number]) as page:
                kinds = [item.type for item in page.get_objects(max_depth=3)]
            counts.append(kinds.count(pdfium.raw.FPDF_PAGEOBJ_PATH))
    if not counts:
        raise InputError("a PDF with pages", "none")
    return [int(k) + 1 for k in np.argsort(-np.array(counts), kind="stable")]


def page_picture(number: int | None = None, side: int = PAGE_SIDE) -> Callable[[Any], Image.Image]:
    """Return a function for :func:`plan2scene.images.decode_image` that renders a page.

    It is a page of a PDF, or an SVG drawing. Its longer side has `side` pixels. Without its
    `number`, from 1, it is the page with the most vector paths.
    """
    return partial(_rendered, number=number, side=side)


def page_texts(path: str | Path, number: int) -> list[tuple[str, np.ndarray]]:
    """Return the texts of a page that are letters in the file, not drawn, with their boxes.

    Pieces of one line are joined. A box (4,) is left, top, right, bottom in pixels of the rendered
    page. There are none for a page that is stored turned.
    """
    with (
        opened(path) as document,
        closing(document[number - 1]) as page,
        closing(page.get_textpage()) as text,
    ):
        if page.get_rotation():
            return []
        rects = [text.get_rect(k) for k in range(min(text.count_rects(), _MAX_TEXTS))]
        words = [(text.get_text_bounded(*rect).strip(), rect) for rect in rects]
        left, bottom, right, top = page.get_cropbox()
    zoom = PAGE_SIDE / max(right - left, top - bottom)
    lines: list[tuple[str, np.ndarray]] = []
    for word, (x0, y0, x1, y1) in words:
        if not word:
            continue
        box = np.array([x0 - left, top - y1, x1 - left, top - y0]) * zoom
        if lines and _goes_on(lines[-1][1], box):
            before, begun = lines.pop()
            apart = " " if box[0] - begun[2] > _SPACE * (box[3] - box[1]) else ""
            word = before + apart + word
            box = np.concatenate([np.minimum(begun, box)[:2], np.maximum(begun, box)[2:]])
        lines.append((word, box))
    return lines


def _goes_on(line: np.ndarray, box: np.ndarray) -> bool:
    """Return whether a box (4,) is the next piece of a line's box (4,)."""
    high = min(line[3] - line[1], box[3] - box[1])
    level = min(line[3], box[3]) - max(line[1], box[1]) > 0.5 * high
    return bool(level and -high < box[0] - line[2] < high)


def _rendered(path: Any, number: int | None, side: int) -> Image.Image:
    if not is_pdf(path):
        return svg_picture(path, side)
    number = number or pages_by_lines(path)[0]
    with opened(path) as document, closing(document[number - 1]) as page:
        return page.render(scale=side / max(page.get_size())).to_pil()
