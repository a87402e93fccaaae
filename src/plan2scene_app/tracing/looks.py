"""First looks at the drawings of a picture by the plan network, and which of them show a home."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from plan2scene_app.tracing.drawings import find_drawings, shows_a_home
from plan2scene_app.tracing.picture import Frame, fills, outline_of, paper_share, whole
from plan2scene_app.tracing.regions import structure_of
from plan2scene_app.tracing.segmenter import PlanSegmenter
from plan2scene_app.tracing.settings import SETTINGS


@dataclass(frozen=True)
class Look:
    """A first look at a drawing: its frame, and `rough` probabilities of the labels there."""

    number: int
    frame: Frame
    rough: np.ndarray
    structure: np.ndarray


def look_at(frame: Frame, number: int, segmenter: PlanSegmenter) -> Look:
    """Return the look at a drawing that a frame shows."""
    rough = segmenter.probabilities(frame.image, views=SETTINGS.first_views)
    return Look(number, frame, rough, structure_of(rough))


def first_looks(image: np.ndarray, segmenter: PlanSegmenter) -> tuple[list[Look], np.ndarray, int]:
    """Return a look at each drawing, their numbers (h, w) int32 in the picture, and their count.

    `image` is (h, w, 3) uint8 sRGB. A single drawing that fills the picture is looked at as it is.
    """
    numbers, count = find_drawings(image)
    looks = [_first_look(image, numbers, n, count, segmenter) for n in range(1, count + 1)]
    return looks, numbers, count


def drawn_homes(looks: Sequence[Look], image: np.ndarray) -> list[Look]:
    """Return the looks at drawings of a picture (h, w, 3) uint8 sRGB that show a home on paper.

    The network sees homes in some photos, too, but there is little paper in them.
    """
    homes = []
    for look in looks:
        if shows_a_home(look.structure):
            corners = outline_of(look.frame, look.structure)
            low = np.maximum(0, np.floor(corners.min(axis=0))).astype(int)
            high = np.ceil(corners.max(axis=0)).astype(int) + 1
            part = image[low[1] : high[1], low[0] : high[0]]
            if paper_share(part) >= SETTINGS.home_paper:
                homes.append(look)
    return homes


def _first_look(
    image: np.ndarray, numbers: np.ndarray, number: int, count: int, segmenter: PlanSegmenter
) -> Look:
    """Return a first look at one drawing; at the whole picture if a single drawing fills it."""
    rows, columns = ndimage.find_objects((numbers == number).astype(int))[0]
    if count == 1 and fills((rows, columns), image.shape):
        return look_at(whole(image, segmenter.long_side), number, segmenter)
    edge = round(0.05 * max(rows.stop - rows.start, columns.stop - columns.start))
    top, left = max(0, rows.start - edge), max(0, columns.start - edge)
    place = (slice(top, rows.stop + edge), slice(left, columns.stop + edge))
    frame = whole(of_drawing(image, numbers, number)[place], segmenter.long_side)
    matrix = frame.matrix.copy()
    matrix[:, 2] -= frame.zoom * np.array([left, top])
    return look_at(Frame(frame.image, matrix), number, segmenter)


def of_drawing(image: np.ndarray, numbers: np.ndarray, number: int) -> np.ndarray:
    """Return a picture (h, w, 3) uint8 with the other drawings painted over."""
    return only(image, (numbers == 0) | (numbers == number))


def only(image: np.ndarray, kept: np.ndarray) -> np.ndarray:
    """Return a picture (h, w, 3) uint8 with paper where `kept` (h, w) bool is false."""
    paper = np.median(image.reshape(-1, 3), axis=0).astype(np.uint8)
    return np.where(kept[..., None], image, paper)
