"""Read the text on a plan offline with RapidOCR (extra ``trace``; its wheel holds the models)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import cv2
import numpy as np
from scipy import ndimage

from plan2scene_app.tracing.settings import SETTINGS

#: The reader enlarges pictures whose shorter side is below this, pixels.
_READER_SIDE = 736


@dataclass(frozen=True)
class TextLine:
    """A line of text around `middle` (pixels x, y); an `upright` one is read up- or downwards."""

    text: str
    middle: tuple[float, float]
    size: tuple[float, float]  #: pixels along x and y
    score: float

    @property
    def upright(self) -> bool:
        """Whether it is clearly higher than wide."""
        return self.size[1] > 1.3 * self.size[0]

    def moved(self, zoom: float, by: tuple[float, float] = (0.0, 0.0)) -> TextLine:
        """Return the line in a picture that is `zoom` times as large, then moved `by` pixels."""
        x, y = (zoom * v + shift for v, shift in zip(self.middle, by, strict=True))
        return replace(self, middle=(x, y), size=(zoom * self.size[0], zoom * self.size[1]))


def reader_installed() -> bool:
    """Return whether text can be read."""
    from importlib.util import find_spec

    return find_spec("rapidocr") is not None and find_spec("onnxruntime") is not None


def read_lines(image: np.ndarray) -> list[TextLine]:
    """Return the lines of text of a picture (h, w, 3) uint8 sRGB."""
    side = max(image.shape[:2])
    factor = min(max(1.0, SETTINGS.text_px[0] / side), SETTINGS.text_px[1] / side)
    if factor != 1:
        how = cv2.INTER_AREA if factor < 1 else cv2.INTER_CUBIC
        image = cv2.resize(image, None, fx=factor, fy=factor, interpolation=how)
    all_lines = _read_whole(image)
    doubtful = [line for line in all_lines if line.upright and _misread(line)]
    lines = [line for line in all_lines if line not in doubtful and _is_sure(line)]
    lines = [_as_it_stands(image, line) for line in lines]
    again = filter(_is_sure, _read_turned(image, doubtful))
    lines += [line for line in again if not any(_holds(one, line) for one in lines)]
    return [line.moved(1 / factor) for line in lines]


def lines_of(image: np.ndarray, told: Sequence[TextLine]) -> list[TextLine]:
    """Return the lines of a picture (h, w, 3) uint8 sRGB: `told` by its file, and further ones.

    The further ones are read, if a reader is installed.
    """
    seen = read_lines(image) if reader_installed() else []
    return [*told, *(line for line in seen if not any(_holds(one, line) for one in told))]


def _holds(one: TextLine, other: TextLine) -> bool:
    """Return whether the box of one line contains the middle of the other."""
    apart = np.abs(np.subtract(one.middle, other.middle))
    return bool((apart < np.array(one.size) / 2).all())


def _is_sure(line: TextLine) -> bool:
    return line.score >= SETTINGS.text_score


def _misread(line: TextLine) -> bool:
    return len(line.text) >= SETTINGS.reread[0] and line.score < SETTINGS.reread[1]


def _read_whole(image: np.ndarray) -> list[TextLine]:
    """Return all lines of a picture; if most of them are upright, it is also read turned.

    The reader can't tell which way up a short name is, but all names of a drawing stand one way:
    the turn with the most letters, weighted by their score, is taken.
    """
    unturned_lines = _read(image)
    words = [line for line in unturned_lines if len(line.text) > 1]
    if len(words) < SETTINGS.turned or sum(line.upright for line in words) <= 0.5 * len(words):
        return unturned_lines
    width, height = image.shape[1], image.shape[0]
    downwards = [
        replace(line, middle=(width - line.middle[1], line.middle[0]), size=line.size[::-1])
        for line in _read(np.rot90(image), one_way=True)
    ]
    upwards = [
        replace(line, middle=(line.middle[1], height - line.middle[0]), size=line.size[::-1])
        for line in _read(np.rot90(image, -1), one_way=True)
    ]

    def letters(lines: Sequence[TextLine]) -> float:
        return sum(len(line.text) * line.score for line in lines if _is_sure(line))

    return max(downwards, upwards, unturned_lines, key=letters)


def _read(image: np.ndarray, *, one_way: bool = False) -> list[TextLine]:
    """Return all that the reader takes for lines of text in a picture (h, w, 3) uint8 sRGB.

    Unless `one_way`, the reader also tests whether a line stands on its head.
    """
    result = _asked(image, use_det=True, use_cls=not one_way)
    if result.boxes is None or result.txts is None:
        return []
    lines = []
    for box, text, score in zip(result.boxes, result.txts, result.scores, strict=True):
        extent = np.ptp(np.asarray(box, float), axis=0)
        # Where there is no text, the reader takes the whole picture for a letter.
        whole = (extent >= 0.95 * np.array(image.shape[1::-1])).all()
        if text.strip() and not whole:
            x, y = np.asarray(box, float).mean(0).tolist()
            lines.append(TextLine(text.strip(), (x, y), tuple(extent.tolist()), float(score)))
    return lines


def _as_it_stands(image: np.ndarray, line: TextLine) -> TextLine:
    """Return a short level line read again without a test for upside down: OH would become HO."""
    if line.upright or len(line.text) > SETTINGS.reread[0]:
        return line
    half = np.array(line.size) / 2 + 0.2 * min(line.size)
    low = np.maximum(0, np.array(line.middle) - half).astype(int)
    high = (np.array(line.middle) + half).astype(int)
    result = _asked(image[low[1] : high[1], low[0] : high[0]], use_det=False, use_cls=False)
    if not result.txts:
        return line
    again = replace(line, text=result.txts[0].strip(), score=float(result.scores[0]))
    return again if again.text and again.score >= SETTINGS.reread[1] else line


def _asked(image: np.ndarray, **ways: bool) -> Any:
    """Return the reader's result; it keeps options of the last call, so all are given each time."""
    return _reader()(np.ascontiguousarray(image[..., ::-1]), text_score=0.0, use_rec=True, **ways)


def _read_turned(image: np.ndarray, lines: Sequence[TextLine]) -> list[TextLine]:
    """Read upright lines once more: turned level, twice as large, on one sheet below each other.

    The reader joins upright lines that stand close together, but not level ones.
    """
    parts, corners = [], []
    for line in lines:
        half = np.array(line.size) / 2 + min(line.size) / 2
        low = np.maximum(0, np.array(line.middle) - half).astype(int)
        high = (np.array(line.middle) + half).astype(int)
        part = np.rot90(image[low[1] : high[1], low[0] : high[0]], -1)
        parts.append(part.repeat(2, axis=0).repeat(2, axis=1))
        corners.append((low[0], low[1] + part.shape[1]))
    if not parts:
        return []
    width = max(_READER_SIDE, *(part.shape[1] for part in parts))
    tops = np.cumsum([0, *(len(part) for part in parts)])
    sheet = np.concatenate(
        [np.pad(p, ((0, 0), (0, width - p.shape[1]), (0, 0)), mode="edge") for p in parts]
    )
    again = []
    for line in _read(sheet):
        x, y = line.middle
        number = int(np.searchsorted(tops, y, side="right")) - 1
        left, bottom = corners[number]
        place = left + (y - tops[number]) / 2, bottom - x / 2
        again.append(replace(line, middle=place, size=(line.size[1] / 2, line.size[0] / 2)))
    return again


def without_text(image: np.ndarray, lines: Sequence[TextLine]) -> np.ndarray:
    """Return a picture (h, w, 3) uint8 with its letters painted over; lines across a text stay.

    Letters are connected components of ink that do not leave the text's box.
    """
    image = image.copy()
    height, width = image.shape[:2]
    for line in lines:
        half = np.array(line.size) / 2 + 0.15 * min(line.size) + 1
        x0, y0 = np.maximum(0, np.floor(np.array(line.middle) - half)).astype(int)
        x1, y1 = np.minimum((width, height), np.ceil(np.array(line.middle) + half)).astype(int)
        part = image[y0:y1, x0:x1]
        if part.size == 0:
            continue
        paper = np.median(part.reshape(-1, 3), axis=0)
        ink = np.abs(part.astype(float) - paper).max(2) > 24
        places, _ = ndimage.label(ink, np.ones((3, 3)))
        rim = np.concatenate([places[0], places[-1], places[:, 0], places[:, -1]])
        part[ink & ~np.isin(places, np.unique(rim[rim > 0]))] = paper
    return image


@cache
def _reader() -> Any:
    """Return the reader; its models are part of its package, nothing is downloaded."""
    from rapidocr import RapidOCR

    return RapidOCR(
        params={
            "Global.log_level": "critical",
            "EngineConfig.onnxruntime.intra_op_num_threads": 1,
            "Det.use_dilation": False,  # close lines stay separate
        }
    )
