"""Crops brought to one scale and orientation, so that whole periods fill the tile."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np

from plan2scene.paint.shading import log_luma
from plan2scene.textures.exemplar.lattice import (
    CropLattice,
    agreed_periods,
    find_lattice,
    whole_periods,
)
from plan2scene.textures.quilting import Source

_SAME = 0.12  # log ratio within which periods of crops of known scale agree
_ALIKE = 0.3  # the same where the scale is unknown
_ODD_TURN = 12.0  # degrees from the usual turn beyond which a crop's angle is not believed
_ENOUGH = 3  # crops that show the agreed period; with so many the others are left out


@dataclass(frozen=True)
class Cut:
    """What the tile holds.

    Attributes
    ----------
    columns, rows : int
        Whole periods along x and y; 0 without one.
    wide, high : float
        Sides in sides of the tile asked for.
    """

    columns: int
    rows: int
    wide: float
    high: float


def find_pattern(
    flat: np.ndarray, masks: np.ndarray, sides: np.ndarray, *, known: bool
) -> tuple[list[CropLattice], Cut, np.ndarray]:
    """Return the crops' lattices, the cut, and which crops show its pattern, (n,) bool.

    Parameters
    ----------
    flat, masks : (n, s, s, 3) float and (n, s, s) bool
        Crops under even light, and their spoiled pixels.
    sides : (n,) float
        Sides of the crops in sides of the tile asked for.
    known : bool
        Whether the crops' scales are known.
    """
    lattices = [find_lattice(log_luma(i), m) for i, m in zip(flat, masks, strict=True)]
    lattices = _usual_turns(lattices)
    size = flat.shape[1]
    tolerance = _SAME if known else _ALIKE
    periods = agreed_periods(lattices, sides, size, tolerance)
    cut = Cut(*whole_periods(periods))
    fits = np.ones(len(lattices), dtype=bool)
    checked = []
    for k, lattice in enumerate(lattices):
        own = [
            p
            if np.isfinite(period) and abs(np.log(p * sides[k] / size / period)) < tolerance
            # a crop without the period is scaled by its metres
            else period * size / sides[k]
            for p, period in zip(lattice.periods, periods, strict=True)
        ]
        fits[k] = all(
            not np.isfinite(period)
            or p == lattice.periods[axis]
            # one that is not two periods large shows a joint twice by chance only
            or (not np.isfinite(lattice.periods[axis]) and known and sides[k] < 2.0 * period)
            for axis, (p, period) in enumerate(zip(own, periods, strict=True))
        )
        checked.append(replace(lattice, periods=(own[0], own[1])))
    if fits.sum() < _ENOUGH:
        fits[:] = True
    return checked, cut, fits


def _usual_turns(lattices: list[CropLattice]) -> list[CropLattice]:
    """Return the lattices with angles near the usual one; it replaces unclear and odd ones.

    Angles are known up to quarter turns: one that is nearer after a quarter turn takes it, its
    axes exchanged. Without a usual angle it is 0.
    """
    quarters = np.radians([4.0 * lattice.angle_deg for lattice in lattices if lattice.clear])
    usual = 0.0
    if 2 * len(quarters) >= len(lattices):
        usual = float(np.degrees(np.angle(np.exp(1j * quarters).mean())) / 4.0)
    result = []
    for lattice in lattices:
        away = (lattice.angle_deg - usual + 45.0) % 90.0 - 45.0
        if not lattice.clear or abs(away) > _ODD_TURN:
            nothing = (float("nan"), float("nan"))
            result.append(replace(lattice, angle_deg=usual, periods=nothing, peaks=(0.0, 0.0)))
        elif abs(usual + away - lattice.angle_deg) > 1.0:
            turned = replace(lattice, periods=lattice.periods[::-1], peaks=lattice.peaks[::-1])
            result.append(replace(turned, angle_deg=usual + away))
        else:
            result.append(lattice)
    return result


def straightened(
    image: np.ndarray, mask: np.ndarray, side: float, lattice: CropLattice, cut: Cut, size: int
) -> Source:
    """Return a crop turned and scaled to a tile of `size` px that holds the cut.

    Parameters
    ----------
    image, mask : (s, s, 3) float and (s, s) bool
        Crop and its spoiled pixels.
    side : float
        Its side in sides of the tile asked for.
    """
    px = image.shape[0]
    steps = []  # crop pixels per tile pixel
    for count, extent, period in zip(
        (cut.columns, cut.rows), (cut.wide, cut.high), lattice.periods, strict=True
    ):
        steps.append(count * period / size if count else extent * px / (side * size))
    turn = np.radians(lattice.angle_deg)
    x_axis = steps[0] * np.array([np.cos(turn), np.sin(turn)])
    y_axis = steps[1] * np.array([-np.sin(turn), np.cos(turn)])
    matrix = np.stack([x_axis, y_axis], axis=1)  # tile offset -> crop offset
    middle = (px - 1) / 2
    corners = np.linalg.inv(matrix) @ (middle * np.array([[-1, 1, 1, -1], [-1, -1, 1, 1]]))
    out = [min(size, max(8, 2 * int(np.floor(np.abs(corners[axis]).max())))) for axis in (0, 1)]
    centre = np.array([(n - 1) / 2 for n in out])
    affine = np.column_stack([matrix, middle - matrix @ centre])
    flags = cv2.WARP_INVERSE_MAP
    size_xy = (out[0], out[1])
    if max(steps) > 1.6:
        image = cv2.GaussianBlur(image, (0, 0), 0.4 * float(np.sqrt(max(steps) ** 2 - 1.0)))
    warped = cv2.warpAffine(
        image.astype(np.float32), affine, size_xy, flags=flags | cv2.INTER_CUBIC
    )
    inside = (~mask).astype(np.float32)
    inside[[0, -1]] = inside[:, [0, -1]] = 0.0
    valid = cv2.warpAffine(inside, affine, size_xy, flags=flags | cv2.INTER_LINEAR) > 0.99
    valid[[0, -1]] = valid[:, [0, -1]] = False  # its borders do not join each other
    return Source(np.clip(warped, 0.0, 1.0), valid)
