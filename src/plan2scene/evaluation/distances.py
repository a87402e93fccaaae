"""FID and KID of a table's cell: predicted textures against the crops of the same surfaces.

Each surface counts once, however many crops show it and however many images were decoded for it.
Houses are added one after another; what is held does not grow with them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plan2scene.errors import InputError
from plan2scene.metrics.feature_sets import kernel_distance, unit_weights
from plan2scene.metrics.running import (
    MAX_MOMENTS_DIMENSION,
    KernelMoments,
    RunningGaussian,
    gaussian_distance,
    moments_distance,
)

#: Surfaces that end a block of :class:`BlockKernel`.
BLOCK_SURFACES = 1000


class SurfaceDistances:
    """FID and KID of measured surfaces, house by house."""

    def __init__(self) -> None:
        self._gaussians = RunningGaussian(), RunningGaussian()
        self._kernel: ExactKernel | BlockKernel | None = None

    def add(self, images: Sequence[np.ndarray], crops: Sequence[np.ndarray]) -> None:
        """Add surfaces of a house: (k, d) features of each one's images, and of each one's crops.

        `crops` leaves out surfaces without any.
        """
        for side, groups in enumerate((images, crops)):
            if not groups:
                continue
            features = np.concatenate(groups).astype(np.float64)
            units = np.repeat(np.arange(len(groups)), [len(group) for group in groups])
            self._gaussians[side].add(features, unit_weights(features, units)[1])
            if self._kernel is None:
                small = features.shape[1] <= MAX_MOMENTS_DIMENSION
                self._kernel = ExactKernel(features.shape[1]) if small else BlockKernel()
            self._kernel.add(side, features, units)

    def values(self) -> dict[str, float]:
        """Return ``FID`` and ``KID``; InputError without any crop."""
        if self._kernel is None or not self._gaussians[1].count:
            raise InputError("reference features of the measured surfaces", "none")
        return {"FID": gaussian_distance(*self._gaussians), "KID": self._kernel.value()}


class ExactKernel:
    """KID of two whole sets."""

    def __init__(self, dimension: int) -> None:
        self._sets = KernelMoments(dimension), KernelMoments(dimension)

    def add(self, side: int, features: np.ndarray, units: np.ndarray) -> None:
        """Add features of whole units to the images (side 0) or crops (1)."""
        self._sets[side].add(features, units, unit_weights(features, units)[1])

    def value(self) -> float:
        """Return KID; NaN with fewer than two surfaces."""
        return moments_distance(*self._sets)


class BlockKernel:
    """KID as the mean over blocks of whole houses of 1,000 surfaces or somewhat more.

    For features of too many dimensions for their third moments. Up to a block it is the KID of
    the whole sets; the mean of more has the same expectation.
    """

    def __init__(self) -> None:
        self._held: tuple[list[np.ndarray], list[np.ndarray]] = ([], [])
        self._units: tuple[list[np.ndarray], list[np.ndarray]] = ([], [])
        self._counts = [0, 0]
        self._sum = self._weight = 0.0

    def add(self, side: int, features: np.ndarray, units: np.ndarray) -> None:
        """Add features of a house's surfaces to the images (side 0, first) or crops (1)."""
        if side == 0 and self._counts[0] >= BLOCK_SURFACES:
            self._close()
        self._held[side].append(features.astype(np.float32))
        self._units[side].append(units + self._counts[side])
        self._counts[side] += int(units[-1]) + 1

    def _close(self) -> None:
        """Count the block that is held, unless it has too few surfaces, and start another."""
        if min(self._counts) >= 2:
            sets = [np.concatenate(parts) for parts in (*self._held, *self._units)]
            self._sum += self._counts[0] * kernel_distance(*sets)
            self._weight += self._counts[0]
        self._held, self._units, self._counts = ([], []), ([], []), [0, 0]

    def value(self) -> float:
        """Return KID; NaN where no block has two surfaces."""
        self._close()
        return self._sum / self._weight if self._weight else float("nan")
