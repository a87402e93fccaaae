"""Pictures of plans: how they are read, and what is told from a plan before it is traced."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from plan2scene.errors import InputError
from plan2scene.images import read_reduced_image
from plan2scene.tracing.labels import ROOM
from plan2scene.tracing.regions import Regions

#: Longer side in pixels that pictures are worked on at, and the least that one may have.
LONG_SIDE, LEAST_SIDE = 2000, 120
#: Grey values that a page must span to have something drawn on it.
CONTRAST = 25
#: Mean probability of the structure found, over the rooms, below which it is no plan.
LEAST_SURE = 0.6


@dataclass(frozen=True)
class PlanPicture:
    """A picture (h, w, 3) uint8 sRGB; a pixel of it is `shrunk` pixels of the file."""

    image: np.ndarray
    shrunk: float


def read_plan_picture(path: str | Path) -> PlanPicture:
    """Return a picture of at most `LONG_SIDE` pixels a side; InputError for an empty page."""
    image, (height, width) = read_reduced_image(path, LONG_SIDE)
    if min(height, width) < LEAST_SIDE:
        expected = f"a plan of at least {LEAST_SIDE} pixels a side"
        raise InputError(expected, f"{width}x{height}", file=path)
    zoom = min(1.0, LONG_SIDE / max(image.shape[:2]))
    if zoom < 1:
        image = cv2.resize(image, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_AREA)
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    low, high = np.percentile(cv2.blur(grey, (3, 3)), [0.2, 99.8])
    if high - low < CONTRAST:
        raise InputError("a picture of a floorplan", "an empty page", file=path)
    return PlanPicture(image, max(height, width) / max(image.shape[:2]))


def refuse_other_pictures(
    path: str | Path, image: np.ndarray, probabilities: np.ndarray, regions: Regions
) -> None:
    """Raise InputError for a photo, a page of text or another picture without a plan."""
    sure = 0.0
    if regions.count:
        best = np.maximum(probabilities[:ROOM].max(0), probabilities[ROOM:].sum(0))
        sure = float(best[regions.rooms > 0].mean())
    if regions.count and sure >= LEAST_SURE:
        return
    expected = "a picture of a floorplan"
    found = "a photo" if is_photo(image) else "no room that walls close"
    if regions.count:
        found += f" (what looks like rooms is {sure:.0%} sure)"
    raise InputError(expected, found, file=path)


def is_photo(image: np.ndarray) -> bool:
    """Return whether a picture (h, w, 3) has as many colours as a photo of things has."""
    small = cv2.resize(image, (256, 256), interpolation=cv2.INTER_AREA)
    paper = np.median(small.reshape(-1, 3), axis=0)
    far = np.abs(small.astype(float) - paper).max(2) > 60
    return bool(far.mean() > 0.35)
