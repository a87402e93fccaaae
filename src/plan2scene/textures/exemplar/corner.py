"""Tiles larger than a crop: a crop that shows the corner of four of them is completed.

Such crops have one straight joint each way and no period. The squares beside the joints are known
to their middles; beyond, each is its own mirror image, which keeps joints straight and squares of
two colours in turn. Their side is what lies between two joints where a crop shows two, else the
longest way from a joint to a crop's border: they are at least so large.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from plan2scene.paint.shading import log_luma
from plan2scene.textures.exemplar.lattice import CropLattice
from plan2scene.textures.exemplar.settings import EXEMPLAR


@dataclass(frozen=True, eq=False)
class Corner:
    """A crop completed."""

    crop: int  #: which of the crops it was made of
    image: np.ndarray  #: (n, n, 3) uint8 sRGB, so many squares each way as the settings say
    side: float  #: side of what it shows, in the tile's sides


def completed(
    images: Sequence[np.ndarray],
    flat: np.ndarray,
    lattices: Sequence[CropLattice],
    order: Sequence[int],
    sides: np.ndarray,
) -> Corner | None:
    """Return a completed crop, of the one that shows most of four squares; None of other surfaces.

    `images` (s, s, 3) uint8 sRGB have the squares' colours, which even light takes for light;
    `flat` (n, s, s, 3) are the same under even light, sRGB in [0, 1]. `order` are those that take
    part, the best first; `sides` (n,) the sides of the crops in sides of the tile.
    """
    if any(np.isfinite(lattices[k].periods).any() for k in order):
        return None
    if not all(lattices[k].clear for k in order):
        return None
    upright = {k: _upright(flat[k], lattices[k].angle_deg) for k in order}
    joints = {k: [_joints(upright[k], axis) for axis in (0, 1)] for k in order}
    straight = np.median([[lines[0][1] for lines in joints[k]] for k in order], axis=0)
    if straight.min() < EXEMPLAR.straight:
        return None
    size = flat.shape[1]
    square = _square(joints, sides, size)
    if not square:
        return None

    def visible(k: int) -> float:
        places = np.array([lines[0][0] for lines in joints[k]])
        return float(np.minimum(places, size - places).min() * sides[k])

    best = max(order, key=visible)
    at = [lines[0][0] for lines in joints[best]]
    own = _upright(images[best] / 255.0, lattices[best].angle_deg)
    image = _folded(own, at, square / sides[best] * size)
    return Corner(best, image, EXEMPLAR.squares * square)


def _upright(image: np.ndarray, angle_deg: float) -> np.ndarray:
    """Return a crop with its joints along its sides."""
    if abs(angle_deg) > EXEMPLAR.upright_deg:
        return image
    middle = ((image.shape[1] - 1) / 2,) * 2
    matrix = cv2.getRotationMatrix2D(middle, angle_deg, 1.0)
    size = image.shape[1::-1]
    return cv2.warpAffine(
        image.astype(np.float32),
        matrix,
        size,
        flags=cv2.INTER_CUBIC,
        borderMode=cv2.BORDER_REFLECT_101,
    )


def _joints(image: np.ndarray, axis: int) -> list[tuple[float, float]]:
    """Return joints across an axis (0: level ones), (place, straightness), the straightest first.

    A joint's straightness is the mean absolute slope of bands along it: with squares of two colours
    in turn the slope changes its sign from band to band.
    """
    luma = cv2.GaussianBlur(log_luma(image).astype(np.float64), (0, 0), 1.5)
    slope = np.diff(luma if axis == 1 else luma.T, axis=1)[
        EXEMPLAR.joint_rim_px : -EXEMPLAR.joint_rim_px
    ]
    slope[:, : EXEMPLAR.joint_rim_px] = slope[:, -EXEMPLAR.joint_rim_px :] = 0.0
    bands = np.stack([band.mean(axis=0) for band in np.array_split(slope, EXEMPLAR.joint_bands)])
    straight = np.abs(bands).mean(axis=0) / max(float(np.sqrt((slope**2).mean())), 1e-9)
    lines: list[tuple[float, float]] = []
    reach = round(EXEMPLAR.joints_apart * image.shape[0])
    while len(lines) < 2:
        place = int(straight.argmax())
        lines.append((place + 0.5, float(straight[place])))
        straight[max(0, place - reach) : place + reach + 1] = 0.0
    return lines


def _square(
    joints: dict[int, list[list[tuple[float, float]]]], sides: np.ndarray, size: int
) -> float:
    """Return the side of a square in the tile's sides."""
    between, reach = [], 0.0
    for k, both in joints.items():
        for (first, _), (second, straight) in both:
            if straight > EXEMPLAR.second:
                between.append(abs(second - first) / size * sides[k])
            reach = max(reach, max(first, size - first) / size * float(sides[k]))
    return float(np.median(between)) if between else reach


def _folded(image: np.ndarray, at: Sequence[float], square: float) -> np.ndarray:
    """Return whole squares of `square` px around the corner at (row, column)."""
    count = min(EXEMPLAR.completed_px, round(EXEMPLAR.squares * square))
    steps = (np.arange(count) + 0.5) / count * EXEMPLAR.squares * square
    inside = np.mod(steps, 2 * square) - square  # a joint at 0 and at both ends
    fold = np.sign(inside) * np.minimum(np.abs(inside), square - np.abs(inside))
    y, x = (np.clip(place + fold, 1, image.shape[0] - 2).astype(np.float32) for place in at)
    columns, rows = np.meshgrid(x, y)
    made = cv2.remap(image.astype(np.float32), columns, rows, cv2.INTER_CUBIC)
    return np.round(255 * made.clip(0, 1)).astype(np.uint8)
