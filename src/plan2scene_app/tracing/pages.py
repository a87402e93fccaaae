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
from plan2scene_app.pdf import page_count, pages_by_lines
from plan2scene_app.tracing.drawings import on_one_page, shows_a_home, storey_told
from plan2scene_app.tracing.lettering import lines_of
from plan2scene_app.tracing.picture import (
    PlanPicture,
    dark_on_light,
    flat_share,
    read_plan_picture,
    whole,
)
from plan2scene_app.tracing.regions import structure_of
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
        return read_plan_picture(path), (1,)
    numbers = pages_by_lines(path)
    homes: dict[int, _Home] = {}
    looks = 0
    for number in numbers:
        try:
            picture = read_plan_picture(path, number)
        except InputError:  # an empty page
            continue
        if flat_share(picture.image) < SETTINGS.busy:  # photos
            continue
        structure = _structure_of_home(picture, segmenter)
        looks += 1
        if structure is not None:
            homes[number] = _Home(picture, structure)
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


@dataclass(frozen=True)
class _Home:
    """A page that shows a home; `structure` (h, w) uint8 are its labels."""

    picture: PlanPicture
    structure: np.ndarray

    @cached_property
    def texts(self) -> tuple[set[int], Counter[str]]:
        """Numbers of storeys that the page tells, and the words inside the home."""
        lines = lines_of(dark_on_light(self.picture.image), self.picture.texts)
        told = {height for line in lines if (height := storey_told(line.text)) is not None}
        zoom = self.structure.shape[0] / self.picture.image.shape[0]
        words: Counter[str] = Counter()
        for line in lines:
            x, y = (int(zoom * v) for v in line.middle)
            inside = 0 <= y < self.structure.shape[0] and 0 <= x < self.structure.shape[1]
            if inside and self.structure[y, x] != OUTSIDE:
                words.update(re.findall(r"\w{2,}", line.text.lower()))
        return told, words


def _structure_of_home(picture: PlanPicture, segmenter: PlanSegmenter) -> np.ndarray | None:
    """Return the labels (h, w) uint8 of a page that shows a home, else None."""
    frame = whole(dark_on_light(picture.image), segmenter.long_side)
    probabilities = segmenter.probabilities(frame.image, views=SETTINGS.first_views)
    structure = structure_of(probabilities)
    return structure if shows_a_home(structure) else None


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
