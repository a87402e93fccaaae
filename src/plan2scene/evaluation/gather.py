"""The measurements of all houses in one table each: metrics, and features of the references."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from plan2scene.errors import InputError
from plan2scene.evaluation.distances import SURFACE
from plan2scene.io import read_parquet
from plan2scene.metrics.registry import METRICS

if TYPE_CHECKING:
    import pandas as pd

#: Metadata that all houses must share.
_NETWORK_METADATA = ("features", "model", "substances", "substance_model")


def read_metrics(files: Iterable[str | Path]) -> tuple[pd.DataFrame, dict[str, str]]:
    """Return all houses' metrics, and the name of each metric's network (``none`` without).

    Raises InputError where the files were measured with different networks.
    """
    import pandas as pd

    frames, found = [], set()
    for file in files:
        frame, metadata = read_parquet(file)
        found.add(tuple(str(metadata.get(name)) for name in _NETWORK_METADATA))
        frames.append(frame)
    if len(found) != 1:
        raise InputError("metrics of one features network", str(sorted(found)))
    known = dict(zip(_NETWORK_METADATA, found.pop(), strict=True))
    networks = {name: known.get(metric.network, "none") for name, metric in METRICS.items()}
    filled = [frame for frame in frames if len(frame)] or frames[:1]
    return pd.concat(filled, ignore_index=True), networks


def read_references(files: Iterable[str | Path]) -> pd.DataFrame:
    """Return the features of all crops of all houses, with a column ``house``."""
    import pandas as pd

    frames = []
    for file in files:
        frame, metadata = read_parquet(file)
        frames.append(frame.assign(house=metadata["house"]))
    filled = [frame for frame in frames if len(frame)]
    if not filled:
        return pd.DataFrame(columns=[*SURFACE, "features"])
    return pd.concat(filled, ignore_index=True)
