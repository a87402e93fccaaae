"""Pictures of plans: how they are read, and what is told from a plan before it is traced."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from shapely.geometry import Polygon

from plan2scene.errors import InputError
from plan2scene.images import read_reduced_image
from plan2scene_app.tracing.labels import ROOM
from plan2scene_app.tracing.regions import Regions

#: Longer side in pixels that pictures are worked on at, and the least that one may have.
LONG_SIDE, LEAST_SIDE = 2000, 120
#: Grey values that a page must span to have something drawn on it.
CONTRAST = 25
#: A page darker than this in the middle of its grey values may be light lines on dark paper, ...
DARK_PAGE = 128
#: ... and has when its lightest marks are so many times further from it than its darkest.
LIGHT_LINES = 1.5
#: Drawings are flat (:func:`flat_share`) at least to this share; most photos of dark rooms are not.
DRAWN_FLAT = 0.42
# Chosen on 34 plans, four of them real, and 40 photos of rooms: no plan and 39 photos are refused.
#: Less sure rooms with more corners on average are none.
RAGGED = (0.82, 11.0)
#: Less sure rooms in a picture with a smaller flat share are none.
BUSY = (0.78, 0.65)


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


def dark_on_light(image: np.ndarray) -> np.ndarray:
    """Return a picture (h, w, 3) uint8 sRGB with dark lines: the negative of light on dark.

    A sheet photographed in a dim room is dark, too, but what is drawn on it is darker.
    """
    grey = cv2.blur(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), (3, 3))
    low, paper, high = np.percentile(grey, [1, 50, 99])
    light = paper < DARK_PAGE and high - paper > LIGHT_LINES * (paper - low)
    return np.asarray(255 - image) if light and flat_share(image) > DRAWN_FLAT else image


def how_sure(probabilities: np.ndarray, regions: Regions) -> float:
    """Return the mean probability of what was found where the rooms are; 0 without rooms."""
    if not regions.count:
        return 0.0
    best = np.maximum(probabilities[:ROOM].max(0), probabilities[ROOM:].sum(0))
    return float(best[regions.rooms > 0].mean())


def refuse_other_pictures(
    path: str | Path,
    image: np.ndarray,
    sure: float,
    polygons: Mapping[int, Polygon],
    openings: int,
) -> None:
    """Raise InputError for a photo, a page of text or another picture without a plan.

    A network sees rooms in a photo, too: hardly sure ones, with ragged outlines, in a picture with
    little that is flat.
    """
    found = ""
    if not polygons:
        found = "no room that walls close"
    elif not openings:
        found = "areas without any door or window"
    else:
        corners = np.mean([len(p.exterior.coords) - 1 for p in polygons.values()])
        ragged = sure < RAGGED[0] and corners > RAGGED[1]
        if ragged or (sure < BUSY[0] and flat_share(image) < BUSY[1]):
            found = f"areas that are {sure:.0%} sure to be rooms"
    if found:
        if flat_share(image) < BUSY[1]:
            found = f"a photo? ({found})"
        raise InputError("a picture of a floorplan", found, file=path)


def flat_share(image: np.ndarray) -> float:
    """Return the share of a picture (h, w, 3) uint8 sRGB that is flat, at 384 pixels a side."""
    zoom = 384 / max(image.shape[:2])
    how = cv2.INTER_AREA if zoom < 1 else cv2.INTER_LINEAR
    small = cv2.medianBlur(cv2.resize(image, None, fx=zoom, fy=zoom, interpolation=how), 3)
    light = cv2.cvtColor(small, cv2.COLOR_RGB2LAB)[..., 0].astype(np.float32)
    slope = np.hypot(cv2.Sobel(light, cv2.CV_32F, 1, 0), cv2.Sobel(light, cv2.CV_32F, 0, 1)) / 8
    return float(np.mean(slope < 1))
