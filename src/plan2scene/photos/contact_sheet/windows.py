"""Windows of a house's candidates.parquet, as its contact sheet shows them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from plan2scene.images import image_from_bytes
from plan2scene.io import read_parquet
from plan2scene.photos.crops.verdict import reasons_of_text

#: sRGB of kept crops, crops kept for want of better ones, and rejected windows.
KEPT, LAST_RESORT, REJECTED = (40, 200, 70), (250, 170, 30), (225, 50, 50)
#: The kinds of windows, with their colours.
KINDS = {"kept": KEPT, "last_resort": LAST_RESORT, "rejected": REJECTED}


@dataclass(frozen=True)
class Window:
    """One candidate window of a photo."""

    surface: str
    plane: int
    kept: bool
    #: Empty for a good one.
    reasons: tuple[str, ...]
    #: Side in metres, NaN where unknown.
    size_m: float
    #: (4, 2) float64: Pixels x, y in the photo, clockwise from the crop's top left; NaN where
    #: unknown.
    corners: np.ndarray
    #: (128, 128, 3) uint8: The crop, of a kept one.
    image: np.ndarray | None = None

    @property
    def kind(self) -> str:
        """Return its kind, of `KINDS`."""
        return "rejected" if not self.kept else "last_resort" if self.reasons else "kept"


def plane_name(surface: str, index: int) -> str:
    """Return a short name of a plane: floor, ceiling, wall 0 ..."""
    return f"wall {index}" if surface == "wall" else surface


def read_windows(crops: str | Path, candidates: str | Path) -> dict[str, tuple[Window, ...]]:
    """Return the windows of each photo, once for all rooms; kept when any room keeps it."""
    table, _ = read_parquet(crops)
    png = dict(zip(table["crop_id"], table["png"], strict=True))
    frame, _ = read_parquet(candidates)
    found: dict[tuple[str, str, int, int], Window] = {}
    for row in frame.to_dict("records"):
        key = (row["photo"], row["surface"], int(row["plane"]), int(row["index"]))
        if key in found and found[key].kept:
            continue
        found[key] = _window(row, png)
    photos: dict[str, list[Window]] = {}
    for (photo, *_), window in found.items():
        photos.setdefault(photo, []).append(window)
    return {photo: tuple(members) for photo, members in photos.items()}


def _window(row: Mapping[str, Any], png: Mapping[str, bytes]) -> Window:
    """Return the window of a row of candidates.parquet."""
    data = png.get(row["crop_id"]) if row["crop_id"] else None
    return Window(
        surface=row["surface"],
        plane=int(row["plane"]),
        kept=bool(row["crop_id"]),
        reasons=reasons_of_text(row["reason"]),
        size_m=float(row["metres"]),
        corners=np.array(list(row["corners"]), np.float64).reshape(4, 2),
        image=None if data is None else image_from_bytes(data),
    )


def count_windows(windows: Sequence[Window]) -> dict[str, int]:
    """Return how many windows are kept, kept for want of better ones, and rejected."""
    kinds = [window.kind for window in windows]
    return {kind: kinds.count(kind) for kind in KINDS}


def thumbnail(window: Window, full: np.ndarray | None, side: int) -> np.ndarray:
    """Return a window (side, side, 3): its crop, else cut out of the photo by its corners."""
    if window.image is not None:
        return cv2.resize(window.image, (side, side), interpolation=cv2.INTER_AREA)
    if full is None or not np.isfinite(window.corners).all():
        return np.full((side, side, 3), 220, np.uint8)
    large = 2 * side
    square = np.array([[0, 0], [large, 0], [large, large], [0, large]], np.float32) - 0.5
    warp = cv2.getPerspectiveTransform(window.corners.astype(np.float32), square)
    cut = cv2.warpPerspective(full, warp, (large, large))
    return cv2.resize(cut, (side, side), interpolation=cv2.INTER_AREA)


def in_turns(windows: Sequence[Window]) -> list[Window]:
    """Return windows in turns over planes and reasons, so that the first few show every kind."""
    groups: dict[tuple[str, int, tuple[str, ...]], list[Window]] = {}
    for window in windows:
        groups.setdefault((window.surface, window.plane, window.reasons), []).append(window)
    turns = zip_longest(*(groups[name] for name in sorted(groups)))
    return [window for turn in turns for window in turn if window is not None]
