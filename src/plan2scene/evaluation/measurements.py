"""The measurements of all houses, one house at a time: metrics, and features of the references."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from plan2scene.errors import InputError
from plan2scene.io import read_parquet, read_parquet_metadata
from plan2scene.metrics.registry import METRICS

if TYPE_CHECKING:
    import pandas as pd

_SURFACE = ["room_id", "surface"]  #: Columns that identify a surface of a house
#: Metadata that all houses must share.
_NETWORK_METADATA = ("features", "model", "substances", "substance_model")


@dataclass(frozen=True)
class MeasuredHouse:
    """A house's rows of ``metrics.parquet``, and the features (n, d) of each surface's crops."""

    name: str
    rows: pd.DataFrame
    crops: Mapping[tuple[str, str], np.ndarray]

    @cached_property
    def surfaces(self) -> list[tuple[str, str]]:
        """Return the surface of each row."""
        return list(zip(*(self.rows[name] for name in _SURFACE), strict=True))

    @cached_property
    def images(self) -> list[np.ndarray]:
        """Return the features (k, d) of each row's images: its tile and the further ones."""
        pairs = zip(self.rows["features"], self.rows["further_features"], strict=True)
        return [np.concatenate(pair).reshape(-1, len(pair[0])) for pair in pairs]

    @cached_property
    def columns(self) -> dict[str, np.ndarray]:
        """Return the other columns as arrays by name; many table cells select rows of them."""
        left_out = ("features", "further_features")
        return {name: self.rows[name].to_numpy() for name in self.rows if name not in left_out}


class Measurements:
    """The files of all houses; only their names and one house at a time are in memory."""

    def __init__(self, metrics: Iterable[str | Path], references: Iterable[str | Path]) -> None:
        self._metrics = list(metrics)
        self._references = {read_parquet_metadata(path)["house"]: path for path in references}

    def networks(self) -> dict[str, str]:
        """Return the name of each metric's network (``none`` for a metric without one).

        Raises InputError where the files were measured with different networks.
        """
        network_sets = set()
        for file in self._metrics:
            metadata = read_parquet_metadata(file)
            network_sets.add(tuple(str(metadata.get(name)) for name in _NETWORK_METADATA))
        if len(network_sets) != 1:
            raise InputError("metrics of one features network", str(sorted(network_sets)))
        network_names = dict(zip(_NETWORK_METADATA, network_sets.pop(), strict=True))
        return {name: network_names.get(metric.network, "none") for name, metric in METRICS.items()}

    def houses(self) -> Iterator[MeasuredHouse]:
        """Yield the houses that have rows, in the order of their files."""
        for file in self._metrics:
            rows, _ = read_parquet(file)
            if len(rows):
                name = str(rows["house"].iloc[0])
                yield MeasuredHouse(name, rows, self._crops(name))

    def _crops(self, house: str) -> dict[tuple[str, str], np.ndarray]:
        """Return the features of a house's crops by surface; an empty dict if it has no file."""
        if house not in self._references:
            return {}
        groups = read_parquet(self._references[house])[0].groupby(_SURFACE)["features"]
        return {key: np.stack(list(features)) for key, features in groups}
