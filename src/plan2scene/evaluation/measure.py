"""The metrics stage of one house: its tiles are compared with reference crops."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from plan2scene.errors import InputError
from plan2scene.evaluation.references import References, reference_images
from plan2scene.house import SUBSTANCES, SurfaceKey
from plan2scene.images import image_from_bytes, metric_image, read_image
from plan2scene.io import read_parquet, write_parquet
from plan2scene.mesh.texture_files import texture_index
from plan2scene.metrics.networks import describe, features_of, network_name
from plan2scene.metrics.registry import IMAGE_COLUMNS, image_metrics
from plan2scene.provenance import file_hash

if TYPE_CHECKING:
    import pandas as pd

#: Columns of ``metrics.parquet`` (docs/conventions.md).
COLUMNS = (
    *("house", "room_id", "surface", "observed", "method", "drop"),
    *IMAGE_COLUMNS,
    *("subs", "substance_predicted", "substance_reference", "features", "further_features"),
)


@dataclass(frozen=True)
class Networks:
    """The weights of two networks: one gives features for FID and KID, one substances for SUBS."""

    features: Path
    substances: Path

    @property
    def metadata(self) -> dict[str, str]:
        """Return the metadata that names both networks and their weights."""
        return {
            "features": network_name(self.features),
            "model": file_hash(self.features),
            "substances": network_name(self.substances),
            "substance_model": file_hash(self.substances),
        }


def measure_textures(
    textures: str | Path,
    crops: str | Path,
    hidden: Mapping[str, Sequence[str]],
    methods: Sequence[str],
    output: str | Path,
    *,
    networks: Networks,
    dataset: str,
    house: str,
) -> None:
    """Write ``metrics.parquet`` of the tiles in the folders ``{drop}/{method}/`` of `textures`.

    `crops` is the house's ``crops.parquet``; `hidden` maps a drop fraction (``"0.6"``) to the
    photos hidden at it.
    """
    table, _ = read_parquet(crops)
    frames = []
    for drop, photos in hidden.items():
        references = reference_images(table, photos)
        for method in methods:
            folder = Path(textures) / drop / method
            entries = texture_index(folder)
            entry_by_key = {
                SurfaceKey(*name.rsplit("/", 1)): entry for name, entry in entries.items()
            }
            keys = [key for key in entry_by_key if key in references]
            numbers = sorted((path for path in folder.glob("more/*")), key=lambda p: int(p.name))
            frames.append(
                measure_tiles(
                    {key: read_image(folder / f"{key.filename}.png") for key in keys},
                    {key for key in keys if entry_by_key[key].get("observed")},
                    references,
                    networks,
                    house_id=house,
                    method=method,
                    drop=drop,
                    more=[
                        read_image(number / f"{key.filename}.png")
                        for key in keys
                        for number in numbers
                    ],
                )
            )
    write_measured(output, frames, {"dataset": dataset, "house": house} | networks.metadata)


def write_measured(
    output: str | Path, frames: Sequence[pd.DataFrame], metadata: Mapping[str, str]
) -> None:
    """Write frames of metrics, one after another, as a file of metrics."""
    import pandas as pd

    filled = [frame for frame in frames if len(frame)] or list(frames[:1])
    write_parquet(output, pd.concat(filled, ignore_index=True), metadata)


def measure_tiles(
    tiles: Mapping[SurfaceKey, np.ndarray],
    observed: Collection[SurfaceKey],
    references: References,
    networks: Networks,
    *,
    house_id: str,
    method: str,
    drop: str,
    more: Sequence[np.ndarray] = (),
) -> pd.DataFrame:
    """Return the rows of ``metrics.parquet``: one for each surface that has any crop.

    `tiles` are (s, s, 3) uint8 sRGB. `observed` surfaces, which a visible photo shows, are compared
    with the medoid of their visible crops, any other with the medoid over all photos
    (:func:`reference_images`). `more` are further images (s, s, 3) uint8 for FID and KID: the same
    number for each surface with a reference, one surface after another.
    """
    import pandas as pd

    keys = [key for key in tiles if key in references]
    seen = [key in observed for key in keys]
    truths = [_truth(key, key in observed, references, house_id) for key in keys]
    values = _measure([metric_image(tiles[key]) for key in keys], truths, networks)
    values["further_features"] = _grouped(networks.features, more, len(keys))
    return pd.DataFrame(
        {
            "house": house_id,
            "room_id": [key.room_id for key in keys],
            "surface": [key.surface for key in keys],
            "observed": np.array(seen, dtype=bool),
            "method": method,
            "drop": drop,
            **values,
        },
        columns=list(COLUMNS),
    )


def _truth(key: SurfaceKey, observed: bool, references: References, house_id: str) -> np.ndarray:
    """Return the image (128, 128, 3) uint8 with which a surface's tile is compared."""
    visible, overall_medoid = references[key]
    if not observed:
        return overall_medoid
    if visible is None:
        expected = f"a visible crop of {key.surface}, which is observed"
        raise InputError(expected, "none", house=house_id, room=key.room_id)
    return visible


def _grouped(model: Path, images: Sequence[np.ndarray], count: int) -> list[np.ndarray]:
    """Return for each of `count` surfaces the concatenated features of its further images."""
    if not images:
        return [np.zeros(0, np.float32)] * count
    return list(features_of(model, images).reshape(count, -1))


def _measure(
    predictions: list[np.ndarray], references: list[np.ndarray], networks: Networks
) -> dict[str, object]:
    """Return the metric columns of paired (128, 128, 3) uint8 images."""
    count = len(predictions)
    if not count:
        return {name: [] for name in COLUMNS[6:]}
    features, classes = describe(networks.features, networks.substances, predictions, references)
    figures = [image_metrics(*pair) for pair in zip(predictions, references, strict=True)]
    return {
        **{name: [row[name] for row in figures] for name in IMAGE_COLUMNS},
        "subs": (classes[:count] != classes[count:]).astype(np.int64),
        "substance_predicted": [SUBSTANCES[c] for c in classes[:count]],
        "substance_reference": [SUBSTANCES[c] for c in classes[count:]],
        "features": list(features),
    }


def reference_features(
    crops: str | Path, model: str | Path, output: str | Path, *, dataset: str, house: str
) -> None:
    """Write ``reference_features.parquet``: the features of every crop of a house."""
    table, _ = read_parquet(crops)
    features = features_of(model, [image_from_bytes(png) for png in table["png"]])
    frame = table[["crop_id", "room_id", "surface"]].assign(features=list(features))
    metadata = {"dataset": dataset, "house": house, "model": file_hash(model)}
    write_parquet(output, frame, {**metadata, "features": network_name(model)})
