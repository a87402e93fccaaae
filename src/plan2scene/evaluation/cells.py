"""The sums behind a table's cells: of each method, column and drop, over all houses in a stream."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from plan2scene.evaluation.gather import MeasuredHouse, Measurements
from plan2scene.metrics.feature_sets import MAX_MOMENTS_DIMENSION, SurfaceDistances
from plan2scene.metrics.registry import METRICS

#: FID and KID are of the whole set; the others are means of a column of ``metrics.parquet``.
MEANS = tuple(name for name in METRICS if name not in ("FID", "KID"))
#: Cells that are summed in one reading of the files: each holds some megabytes of moments, those
#: of features of many dimensions (InceptionV3's 2048) some hundred.
_AT_ONCE, _AT_ONCE_WIDE = 48, 3


@dataclass
class Cell:
    """Sums over the surfaces of a method, column and drop: a byte a house is held.

    Attributes
    ----------
    present : bytearray
        Of each house of the table: 1 with results of method and drop, 2 with surfaces counted.
    """

    method: str
    column: str
    drop: str
    present: bytearray
    n: int = 0
    images: int = 0
    sums: np.ndarray = field(default_factory=lambda: np.zeros((2, len(MEANS))))
    distances: SurfaceDistances = field(default_factory=SurfaceDistances)

    def add(self, place: int, house: MeasuredHouse) -> None:
        """Add the surfaces of the house of that place in the table."""
        columns = house.columns
        chosen = (columns["method"] == self.method) & (columns["drop"] == self.drop)
        if chosen.any():
            self.present[place] = max(self.present[place], 1)
        if self.column != "all":
            chosen &= columns["observed"].astype(bool) == (self.column == "observed")
        rows = np.flatnonzero(chosen)
        if not len(rows):
            return
        self.present[place] = 2
        self.n += len(rows)
        images = [house.images[row] for row in rows]
        self.images += sum(map(len, images))
        values = np.array([columns[name.lower()][rows] for name in MEANS], dtype=np.float64)
        self.sums += np.nansum(values, axis=1), (~np.isnan(values)).sum(axis=1)
        surfaces = dict.fromkeys(house.surfaces[row] for row in rows)
        crops = [house.crops[key] for key in surfaces if key in house.crops]
        self.distances.add(images, crops)

    def values(self) -> dict[str, float]:
        """Return the value of each metric; NaN where no surface is counted."""
        if not self.n:
            return dict.fromkeys(METRICS, float("nan"))
        total, count = self.sums
        means = np.divide(total, count, out=np.full(len(MEANS), np.nan), where=count > 0)
        return dict(zip(MEANS, means.tolist(), strict=True)) | self.distances.values()


def summed(cells: Sequence[Cell], houses: Mapping[str, int], measured: Measurements) -> None:
    """Add all measured houses, which have their place in the table, to the cells.

    The files are read again for every few dozen cells.
    """
    left = list(cells)
    while left:
        own = left[:_AT_ONCE]
        for house in measured.houses():
            if house.images[0].shape[1] > MAX_MOMENTS_DIMENSION:
                own = own[:_AT_ONCE_WIDE]
            if house.name in houses:
                for cell in own:
                    cell.add(houses[house.name], house)
        left = left[len(own) :]
