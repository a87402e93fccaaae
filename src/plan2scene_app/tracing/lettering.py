"""What is written on a plan, read offline by RapidOCR (extra ``trace``; models in its wheel)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import cv2
import numpy as np
from scipy import ndimage

from plan2scene_app.tracing.settings import SETTINGS


@dataclass(frozen=True)
class TextLine:
    """A line of text at `middle` (pixels x, y); `upright` is read upwards or downwards."""

    text: str
    middle: tuple[float, float]
    size: tuple[float, float]  #: pixels along x and y
    score: float

    @property
    def upright(self) -> bool:
        """Whether it is higher than wide."""
        return self.size[1] > 1.3 * self.size[0]


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
    result = _reader()(np.ascontiguousarray(image[..., ::-1]))
    if result.boxes is None or result.txts is None:
        return []
    lines = []
    for box, text, score in zip(result.boxes, result.txts, result.scores, strict=True):
        extent = np.ptp(np.asarray(box, float), axis=0)
        # Where there is no text, the reader takes the whole picture for a letter.
        whole = (extent >= 0.95 * np.array(image.shape[1::-1])).all()
        if score >= SETTINGS.text_score and text.strip() and not whole:
            x, y = (np.asarray(box, float).mean(0) / factor).tolist()
            w, h = (extent / factor).tolist()
            lines.append(TextLine(text.strip(), (x, y), (w, h), float(score)))
    return lines


def without_text(image: np.ndarray, lines: Sequence[TextLine]) -> np.ndarray:
    """Return a picture (h, w, 3) uint8 whose letters are paper; lines that cross a text stay.

    Letters are ink of which nothing leaves the text's box.
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
    """Return the reader; its models lie in its package, nothing is fetched."""
    from rapidocr import RapidOCR

    return RapidOCR(
        params={"Global.log_level": "critical", "EngineConfig.onnxruntime.intra_op_num_threads": 1}
    )
