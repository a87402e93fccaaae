"""Kinds and geometry of floor patterns, for finding them in photos and for laying them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

#: Kinds of pattern that are laid from single units.
LAID = ("planks", "tiles", "herringbone", "chevron")
#: Pixels per metre of the images that patterns are read from and of the units cut out of them.
PX_PER_M = 200.0


@dataclass(frozen=True)
class Zigzag:
    """A pattern of slanting planks in columns."""

    kind: str  #: ``herringbone`` or ``chevron``
    #: width_m, length_m: sides of a plank, with half a joint on each side
    width_m: float
    length_m: float
    slant_deg: float = 45.0  #: angle between planks and columns

    @property
    def period_m(self) -> tuple[float, float]:
        """Return the pattern's periods along its columns and across them, metres."""
        sine = np.sin(np.radians(self.slant_deg))
        return float(self.width_m / sine), float(2 * self.length_m * sine)

    def planks(
        self, along: np.ndarray, across: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Find the plank at each place (n,), given in metres along and across the columns.

        Returns the plank's numbers (n, 2), the place relative to its middle, along and across it,
        and the distance of the place to its border, metres.
        """
        parts = self._chevron if self.kind == "chevron" else self._herringbone
        return parts(np.asarray(along, np.float64), np.asarray(across, np.float64))

    def _chevron(
        self, along: np.ndarray, across: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        step, wide = self.period_m[0], self.period_m[1] / 2
        sine, cosine = (f(np.radians(self.slant_deg)) for f in (np.sin, np.cos))
        column = np.floor(across / wide)
        inside = across - (column + 0.5) * wide
        way = np.where(column % 2 == 0, 1.0, -1.0)
        shifted = along - way * inside * cosine / sine
        number = np.floor(shifted / step)
        y = (shifted - (number + 0.5) * step) * sine
        border = np.minimum(self.width_m / 2 - np.abs(y), wide / 2 - np.abs(inside))
        return np.stack([number, column], axis=-1).astype(int), inside / sine, y, border

    def _herringbone(
        self, along: np.ndarray, across: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        p, q = (along + across) / np.sqrt(2), (along - across) / np.sqrt(2)
        width, length = self.width_m, self.length_m
        base = np.floor((p - q) / (2 * length))
        number = np.zeros((*p.shape, 2), int)
        x, y, border = np.zeros(p.shape), np.zeros(p.shape), np.full(p.shape, -np.inf)
        for turn in (0, 1):  # planks along p, and those along q at their ends
            for m in (base - 1, base, base + 1):
                if turn:
                    k = np.floor((p - (m + 1) * length) / width)
                    dy = p - (m + 1) * length - (k + 0.5) * width
                    dx = q - (k + 1) * width + (m + 0.5) * length
                else:
                    k = np.floor((q + m * length) / width)
                    dy = q + m * length - (k + 0.5) * width
                    dx = p - k * width - (m + 0.5) * length
                edge = np.minimum(length / 2 - np.abs(dx), width / 2 - np.abs(dy))
                own = edge > border
                number[own] = np.stack([k, 2 * m + turn], axis=-1)[own]
                x, y, border = (np.where(own, *pair) for pair in ((dx, x), (dy, y), (edge, border)))
        return number, x, y, border
