"""Pages of a PDF: find those that show storeys of the home."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from plan2scene.errors import InputError
from plan2scene.images import read_reduced_image
from plan2scene_app.pdf import is_pdf, page_count, page_picture, pages_by_lines
from plan2scene_app.tracing.drawings import on_one_page, storey_told
from plan2scene_app.tracing.lettering import lines_of, without_text
from plan2scene_app.tracing.looks import Look, drawn_homes, first_looks
from plan2scene_app.tracing.picture import (
    PlanPicture,
    dark_on_light,
    flat_share,
    read_plan_picture,
)
from plan2scene_app.tracing.segmenter import PlanSegmenter
from plan2scene_app.tracing.settings import OUTSIDE, SETTINGS


def read_plan_pages(
    path: str | Path, segmenter: PlanSegmenter
) -> tuple[PlanPicture, tuple[int, ...]]:
    """Return the picture of a plan, and the numbers, from 1, of the pages that it shows.

    Of a PDF with several pages, those that show a home are put on one page, as storeys. A page that
    shows the same plan as another one, with furniture for instance, is left out.
    InputError as `read_plan_picture`.
    """
    if page_count(path) == 1:
        return read_plan_picture(path, 1 if is_pdf(path) else None), (1,)
    numbers = pages_by_lines(path)
    homes: dict[int, _Home] = {}
    looks = 0
    for number in numbers:
        if flat_share(_small(path, number)) < SETTINGS.photo_flat:
            continue
        try:
            picture = read_plan_picture(path, number)
        except InputError:  # an empty page
            continue
        page = without_text(dark_on_light(picture.image), picture.texts)
        shown = drawn_homes(first_looks(page, segmenter)[0], page)
        looks += 1
        if shown:
            homes[number] = _Home(picture, shown)
        if looks == SETTINGS.most_pages or len(homes) == SETTINGS.most_drawings:
            break
    pages = tuple(sorted(homes))
    if len(pages) > 1:
        pages = tuple(n for k, n in enumerate(pages) if not _shown(homes[n], homes, pages[:k]))
    if not pages:
        return read_plan_picture(path, numbers[0]), (numbers[0],)
    if len(pages) == 1:
        return homes[pages[0]].picture, pages
    joined = on_one_page([homes[number].picture for number in pages])
    return joined.resized(SETTINGS.long_side_px / max(joined.image.shape[:2])), pages


def _small(path: str | Path, number: int) -> np.ndarray:
    """Return a page (h, w, 3) uint8 sRGB of few pixels."""
    side = SETTINGS.page_side_px
    return read_reduced_image(path, side, page_of=page_picture(number, side))[0]


@dataclass(frozen=True)
class _Home:
    """A page that shows a home, and the looks at those of its drawings that do."""

    picture: PlanPicture
    looks: list[Look]

    @cached_property
    def texts(self) -> tuple[set[int], Counter[str]]:
        """Numbers of storeys that the page tells, and the words inside the home."""
        lines = lines_of(dark_on_light(self.picture.image), self.picture.texts)
        told = {height for line in lines if (height := storey_told(line.text)) is not None}
        words: Counter[str] = Counter()
        for line in lines:
            for look in self.looks:
                x, y = look.frame.of_picture(np.array([line.middle]))[0].astype(int)
                height, width = look.structure.shape
                if 0 <= y < height and 0 <= x < width and look.structure[y, x] != OUTSIDE:
                    words.update(re.findall(r"\w{2,}", line.text.lower()))
        return told, words


def _shown(home: _Home, homes: Mapping[int, _Home], before: Sequence[int]) -> bool:
    """Return whether one of the pages `before` shows the same plan as a home's page."""
    return any(_same_plan(home, homes[number]) for number in before)


def _same_plan(one: _Home, other: _Home) -> bool:
    """Return whether two pages show one plan, by their captions, else the words in the home."""
    (told, words), (other_told, other_words) = one.texts, other.texts
    if told and other_told and told != other_told:
        return False
    shared = (words & other_words).total()
    return shared >= max(1.0, SETTINGS.same_words * (words | other_words).total())
