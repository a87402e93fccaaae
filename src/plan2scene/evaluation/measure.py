"""The metrics stage of one house: its tiles against the crops that stand for the truth."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from plan2scene.errors import InputError
from plan2scene.evaluation.resampling import FurtherSeeds, further_images
from plan2scene.house import SUBSTANCES, SurfaceKey
from plan2scene.images import METRIC_SIZE, image_from_bytes, metric_image, read_image
from plan2scene.io import read_json, read_parquet, write_parquet
from plan2scene.metrics.networks import describe, features_of, network_name
from plan2scene.metrics.registry import IMAGE_COLUMNS, image_metrics
from plan2scene.photos.crops.sampling import medoid_index
from plan2scene.provenance import file_hash

if TYPE_CHECKING:
    import pandas as pd

COLUMNS = (
    *("house", "room_id", "surface", "observed", "method", "drop"),
    *IMAGE_COLUMNS,
    *("subs", "substance_predicted", "substance_reference", "features", "further_features"),
)


#: Of each surface with crops: the medoid of its visible ones, if any, and that of all.
References: TypeAlias = Mapping[SurfaceKey, tuple[np.ndarray | None, np.ndarray]]


def measure_house(
    textures: str | Path,
    references: References,
    model: str | Path,
    output: str | Path,
    *,
    dataset: str,
    house: str,
    method: str,
    drop: str,
    substance_model: str | Path | None = None,
    further: FurtherSeeds | None = None,
) -> None:
    """Write ``metrics.parquet`` (docs/conventions.md): a row per surface that has any crop.

    Parameters
    ----------
    textures : path
        Folder of the texture stage.
    references : mapping
        Of :func:`read_references`: an observed surface is compared with the medoid of its
        visible crops, any other with the medoid over all photos.
    model : path
        Weights of the network whose features FID and KID compare.
    drop : str
        Share of photos hidden, one decimal.
    substance_model : path, optional
        Weights of the network that SUBS asks; None: `model`.
    further : FurtherSeeds, optional
        Decode more images of each surface for FID and KID; None for a method that has one image.
    """
    import pandas as pd

    entries = read_json(Path(textures) / "textures.json")["surfaces"]
    keys, observed, predictions, truths = [], [], [], []
    for name, entry in entries.items():
        key = SurfaceKey(*name.rsplit("/", 1))
        visible, every = references.get(key, (None, None))
        if every is None:
            continue
        if entry["observed"] and visible is None:
            raise InputError(
                f"a visible crop of {name}, observed at drop {drop}",
                "none",
                file=Path(textures) / "textures.json",
                house=house,
            )
        keys.append(key)
        observed.append(bool(entry["observed"]))
        tile = read_image(Path(textures) / f"{key.filename}.png", house=house)
        predictions.append(metric_image(tile))
        truths.append(visible if entry["observed"] and visible is not None else every)
    values = _measure(predictions, truths, model, substance_model or model)
    more = further_images(further, keys, method=method, house=house) if further else []
    values["further_features"] = _grouped(model, more, len(keys))
    frame = pd.DataFrame(
        {
            "house": house,
            "room_id": [key.room_id for key in keys],
            "surface": [key.surface for key in keys],
            "observed": np.array(observed, dtype=bool),
            "method": method,
            "drop": drop,
            **values,
        },
        columns=list(COLUMNS),
    )
    metadata = {"dataset": dataset, "house": house, **_networks(model, substance_model or model)}
    write_parquet(output, frame, metadata)


def _networks(model: str | Path, substance_model: str | Path) -> dict[str, str]:
    """Return the metadata that names both networks and their weights."""
    return {
        "features": network_name(model),
        "model": file_hash(model),
        "substances": network_name(substance_model),
        "substance_model": file_hash(substance_model),
    }


def _grouped(model: str | Path, images: list[np.ndarray], count: int) -> list[np.ndarray]:
    """Return for each of `count` surfaces the features of its further images, one after another."""
    if not images:
        return [np.zeros(0, np.float32)] * count
    return list(features_of(model, images).reshape(count, -1))


def read_references(crops: str | Path, hidden_photos: Collection[str]) -> References:
    """Return the :func:`reference_images` of ``crops.parquet``, which has hidden photos too."""
    return reference_images(read_parquet(crops)[0], hidden_photos)


def reference_images(crops: pd.DataFrame, hidden_photos: Collection[str]) -> References:
    """Return for each surface with crops the medoid of its visible ones and that of all.

    Both (128, 128, 3) uint8; the first is None for a surface that only hidden photos show.
    """
    hidden = set(hidden_photos)
    result = {}
    for (room_id, surface), group in crops.groupby(["room_id", "surface"], sort=False):
        images = [metric_image(image_from_bytes(png)) for png in group["png"]]
        seen = [i for i, photo in zip(images, group["photo"], strict=True) if photo not in hidden]
        visible = seen[medoid_index(seen)] if seen else None
        key = SurfaceKey(str(room_id), str(surface))
        result[key] = (visible, images[medoid_index(images)])
    return result


def _measure(
    predictions: list[np.ndarray],
    references: list[np.ndarray],
    model: str | Path,
    substance_model: str | Path,
) -> dict[str, object]:
    """Return the metric columns of paired (128, 128, 3) uint8 images."""
    count = len(predictions)
    shape = (-1, METRIC_SIZE, METRIC_SIZE, 3)
    predicted = np.array(predictions, dtype=np.uint8).reshape(shape)
    wanted = np.array(references, dtype=np.uint8).reshape(shape)
    if not count:
        return {name: [] for name in COLUMNS[6:]}
    features, classes = describe(model, substance_model, predictions, references)
    return {
        **image_metrics(predicted, wanted),
        "subs": (classes[:count] != classes[count:]).astype(np.int64),
        "substance_predicted": [SUBSTANCES[c] for c in classes[:count]],
        "substance_reference": [SUBSTANCES[c] for c in classes[count:]],
        "features": list(features),
    }


def reference_features(
    crops: str | Path, model: str | Path, output: str | Path, *, dataset: str, house: str
) -> None:
    """Write ``reference_features.parquet``: the features of every crop of a house."""
    import pandas as pd

    table, _ = read_parquet(crops)
    features = features_of(model, [image_from_bytes(png) for png in table["png"]])
    frame = pd.DataFrame(
        {
            "crop_id": table["crop_id"],
            "room_id": table["room_id"],
            "surface": table["surface"],
            "features": list(features),
        }
    )
    metadata = {"dataset": dataset, "house": house, "model": file_hash(model)}
    write_parquet(output, frame, {**metadata, "features": network_name(model)})
