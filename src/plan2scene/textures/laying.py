"""Floors laid from whole planks and tiles that were cut out of photos.

The grid is the plan's, not the room's: a floor runs on through doors, planks and all. A row is a
tape of all units, shifted and mirrored anew in each row, so that equal ones are never side by side.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from plan2scene.colour import as_uint8
from plan2scene.house import SurfaceKey
from plan2scene.images import image_from_bytes
from plan2scene.io import read_parquet
from plan2scene.photos.patterns.joints import JOINTS
from plan2scene.plans.surface_areas import Area


@dataclass(frozen=True)
class LayingSettings:
    """Tuned constants. Chosen by looking at maps of development homes."""

    least_units: int = 6  #: with fewer, the same ones would lie side by side
    px_per_m: float = 256.0  #: of a map
    upright_deg: float = 6.0  #: from the plan's axes, within which a floor lies along them
    apart: float = 0.382  #: of the tape, by which it is shifted from row to row


LAYING = LayingSettings()


@dataclass(frozen=True, eq=False)
class LaidPattern:
    """How a floor is laid, a row of ``patterns.parquet`` (docs/conventions.md).

    Attributes
    ----------
    kind : str
        ``planks`` or ``tiles``.
    width_m, length_m : float
        Of a unit; length NaN for planks of many lengths.
    direction_deg : float
        Of the length, from +x towards +z; NaN where not known.
    offset : float
        Of a row against the row before, over the length.
    joint : (3,) float
        By how much a joint's sRGB is less than its units', over theirs.
    joint_m : float
    units : list of (h, w, 3) uint8
        sRGB levels, 127.5 where the floor has its usual colour.
    """

    kind: str
    width_m: float
    length_m: float
    direction_deg: float
    offset: float
    joint: np.ndarray
    joint_m: float
    units: list[np.ndarray]

    @property
    def words(self) -> str:
        """Return kind and size as ``planks 15 x 60 cm``."""
        width = f"{self.kind} {100 * self.width_m:.0f}"
        known = np.isfinite(self.length_m)
        return f"{width} x {100 * self.length_m:.0f} cm" if known else f"{width} cm wide"


def read_patterns(path: str | Path) -> dict[SurfaceKey, LaidPattern]:
    """Return the patterns of ``patterns.parquet`` that floors can be laid by."""
    table, _ = read_parquet(path)
    found = {}
    for row in table.itertuples():
        enough = len(row.units) >= LAYING.least_units
        if row.kind not in ("planks", "tiles") or not enough:
            continue
        found[SurfaceKey(row.room_id, row.surface)] = LaidPattern(
            row.kind,
            float(row.width_m),
            float(row.length_m),
            float(row.direction_deg),
            float(row.offset),
            np.array(row.joint, dtype=np.float64),
            float(row.joint_m),
            [image_from_bytes(unit) for unit in row.units],
        )
    return found


def pattern_of(patterns: Mapping[SurfaceKey, LaidPattern], *keys: SurfaceKey) -> LaidPattern | None:
    """Return the pattern of the first of some surfaces that has one."""
    return next((patterns[key] for key in keys if key in patterns), None)


def laid(
    pattern: LaidPattern, area: Area, colour: np.ndarray, seed: int
) -> tuple[np.ndarray, Area]:
    """Return a floor's image (h, w, 3) uint8 sRGB, and the area that it covers.

    Rows are +z and columns +x of the plan. `colour` (3,) is the floor's usual sRGB in [0, 1]. With
    one `seed` floors run on from room to room.
    """
    scale = LAYING.px_per_m
    low = np.floor(np.array(area.low) * scale).astype(int)
    size = np.ceil(np.array(area.high) * scale).astype(int) - low
    angle = pattern.direction_deg
    if not np.isfinite(angle):
        angle = 0.0 if size[0] >= size[1] else 90.0
    upright = round(angle / 90.0) * 90.0
    if abs(angle - upright) <= LAYING.upright_deg:
        angle = upright
    turn = np.array(
        [
            [np.cos(np.radians(angle)), np.sin(np.radians(angle))],
            [-np.sin(np.radians(angle)), np.cos(np.radians(angle))],
        ]
    )
    corners = low + size * np.array([[0, 0], [1, 0], [0, 1], [1, 1]])
    along = corners @ turn.T
    first, last = np.floor(along.min(axis=0)).astype(int), np.ceil(along.max(axis=0)).astype(int)
    rows = _rows(pattern, (first[0], last[0] + 1), (first[1], last[1] + 1), scale, seed)
    # Pixel middles of the map, in those of the rows.
    middle = turn @ (low + 0.5) - first - 0.5
    to_rows = np.column_stack([turn, middle])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    shape = (int(size[0]), int(size[1]))
    image = cv2.warpAffine(rows, to_rows, shape, flags=flags, borderMode=cv2.BORDER_REPLICATE)
    whole = as_uint8(np.clip(2.0 * image * colour, 0.0, 1.0))
    far = (low + size) / scale
    begin = low / scale
    return whole, Area((float(begin[0]), float(begin[1])), (float(far[0]), float(far[1])))


def _rows(
    pattern: LaidPattern, across: tuple[int, int], down: tuple[int, int], scale: float, seed: int
) -> np.ndarray:
    """Return rows of units (h, w, 3) float32, 0.5 where the floor has its usual colour.

    `across` and `down`: first and last pixel of the grid, whose rows begin at 0.
    """
    width = pattern.width_m * scale
    canvas = np.full((down[1] - down[0], across[1] - across[0], 3), 0.5, np.float32)
    depth = pattern.joint.astype(np.float32)
    joint = max(pattern.joint_m * scale, 1e-6)
    for number in range(int(np.floor(down[0] / width)), int(np.ceil(down[1] / width)) + 1):
        top, bottom = number * width, (number + 1) * width
        row, ends = _tape(pattern, number, across, round(bottom) - round(top), scale, seed)
        line = _coverage(np.arange(round(top), round(bottom)) + 0.5, [top, bottom], joint)
        joints = np.maximum(line[:, None], _coverage(np.arange(*across) + 0.5, ends, joint))
        row *= 1.0 - joints[..., None] * depth
        first, last = max(round(top), down[0]), min(round(bottom), down[1])
        if first < last:
            canvas[first - down[0] : last - down[0]] = row[first - round(top) : last - round(top)]
    return canvas


def _tape(
    pattern: LaidPattern, number: int, across: tuple[int, int], height: int, scale: float, seed: int
) -> tuple[np.ndarray, list[float]]:
    """Return a row of units (height, w, 3) between two pixels, and where units end."""
    count = len(pattern.units)
    rng = np.random.default_rng([seed, number % (1 << 32)])
    order = np.random.default_rng(seed).permutation(count)
    lengths = [unit.shape[1] / JOINTS.px_per_m * scale for unit in pattern.units]
    if np.isfinite(pattern.length_m):
        lengths = [pattern.length_m * scale] * count
        begin = (pattern.offset * number % 1.0) * lengths[0]
    else:
        begin = float(rng.uniform(0.0, sum(lengths)))
    mirrored = rng.random((count, 2)) < 0.5
    row = np.full((height, across[1] - across[0], 3), 0.5, np.float32)
    k = round(LAYING.apart * count * number)
    tape = sum(lengths)
    turns = int(np.floor((across[0] - begin) / tape))
    end, ends = begin + turns * tape, []
    while end < across[1]:
        which = int(order[k % count])
        start, end, k = end, end + lengths[which], k + 1
        ends.append(end)
        left, right = round(start), round(end)
        low, high = max(left, across[0]), min(right, across[1])
        if low >= high:
            continue
        unit = pattern.units[which]
        unit = unit[:, :: -1 if mirrored[which, 0] else 1][:: -1 if mirrored[which, 1] else 1]
        size = (right - left, height)
        image = cv2.resize(np.ascontiguousarray(unit), size, interpolation=cv2.INTER_LINEAR)
        row[:, low - across[0] : high - across[0]] = image[:, low - left : high - left] / 255.0
    return row, ends


def _coverage(places: np.ndarray, joints: list[float], width: float) -> np.ndarray:
    """Return how much of each pixel (n,) at `places` the joints cover, 0..1."""
    if not joints:
        return np.zeros(len(places))
    ordered = np.sort(joints)
    at = np.searchsorted(ordered, places)
    before = np.abs(places - ordered[np.maximum(at - 1, 0)])
    after = np.abs(ordered[np.minimum(at, len(ordered) - 1)] - places)
    away = np.minimum(before, after)
    covered = np.clip((max(width, 1.0) / 2 - away) + 0.5, 0.0, 1.0) * min(1.0, width)
    return np.asarray(covered)
