"""The propagation stage of one house: observed surfaces keep their embedding, others get one."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from plan2scene.floorplans.scene_json import read_scene_json
from plan2scene.house import SURFACES, House, SurfaceKey
from plan2scene.io import read_parquet, write_parquet
from plan2scene.propagation.graph import house_graph
from plan2scene.propagation.inference import (
    SubstanceHead,
    read_propagation,
    read_substance_head,
)
from plan2scene.propagation.predict import Prediction, predict
from plan2scene.propagation.prior import TypeMeans
from plan2scene.provenance import file_hash

#: Metres that a tile covers where the house shows no scale at all.
DEFAULT_METRES = 1.0


def _metres(known: Mapping[SurfaceKey, float], key: SurfaceKey) -> float:
    """Return a surface's tile size: its own, else the median of its kind, else of the house."""
    if np.isfinite(known.get(key, np.nan)):
        return known[key]
    alike = [v for k, v in known.items() if k.surface == key.surface and np.isfinite(v)]
    every = alike or [v for v in known.values() if np.isfinite(v)]
    return float(np.median(every)) if every else DEFAULT_METRES


def propagate_house(
    scene_json: str | Path,
    surfaces: str | Path,
    output: str | Path,
    *,
    house: str,
    dataset: str,
    propagation_model: str | Path,
    texture_model: str | Path,
) -> None:
    """Write ``propagated.parquet`` (docs/conventions.md): a row for every surface of the house."""
    import pandas as pd

    plan = read_scene_json(scene_json, house)
    table, _ = read_parquet(surfaces)
    network, means = read_propagation(propagation_model)
    head = read_substance_head(texture_model)
    observed = {SurfaceKey(row.room_id, row.surface): row for row in table.itertuples()}
    graph = house_graph(plan, {k: np.asarray(row.embedding) for k, row in observed.items()})
    predicted = predict(network, graph)
    known = {key: float(row.metres) for key, row in observed.items()}
    rows = []
    for key in plan.surface_keys():
        row = observed.get(key)
        if row is None:
            values = _predicted_row(plan, key, graph.room_ids, predicted, means, head)
        else:
            values = {
                "observed": True,
                "embedding": np.asarray(row.embedding, dtype=np.float32),
                "naive_embedding": np.asarray(row.naive_embedding, dtype=np.float32),
                "substance": row.substance,
                "source": row.crop_id,
                "confidence": 1.0,
            }
        rows.append(
            {"room_id": key.room_id, "surface": key.surface, "metres": _metres(known, key)} | values
        )
    columns = ["room_id", "surface", "observed", "embedding", "naive_embedding"]
    columns += ["substance", "metres", "source", "confidence"]
    write_parquet(
        output,
        pd.DataFrame(rows, columns=columns),
        {"dataset": dataset, "house": house, "model": file_hash(propagation_model)},
    )


def _predicted_row(
    plan: House,
    key: SurfaceKey,
    room_ids: tuple[str, ...],
    predicted: Prediction,
    means: TypeMeans,
    head: SubstanceHead,
) -> dict[str, object]:
    """Return the values of a surface that no visible photo shows."""
    place = room_ids.index(key.room_id), SURFACES.index(key.surface)
    embedding, alike = predicted.embedding[place], int(predicted.alike[place])
    _, naive = means.predict(plan.room(key.room_id).types, key.surface)
    return {
        "observed": False,
        "embedding": embedding,
        "naive_embedding": naive.astype(np.float32),
        "substance": head.name(embedding),
        "source": "propagated" if alike < 0 else f"propagated, like {room_ids[alike]}",
        "confidence": float(predicted.confidence[place]),
    }
