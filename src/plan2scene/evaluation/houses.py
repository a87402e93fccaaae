"""One house through selection, propagation, textures and metrics in one process.

A comparison of methods, a sweep or an ablation repeats these steps dozens of times per house; as
jobs of their own, most of their time would be the start of processes. The functions are those of
the stages, so the figures are theirs.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING

from plan2scene.evaluation.measure import measure_house, read_references
from plan2scene.io import read_parquet, write_parquet
from plan2scene.metrics.networks import network_name
from plan2scene.propagation.stage import propagate_house
from plan2scene.provenance import file_hash
from plan2scene.textures.methods import DECODERS
from plan2scene.textures.selection import select_surfaces
from plan2scene.textures.stage import make_textures

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class HouseFiles:
    """Files of one house that do not depend on the drop, and what baselines take from elsewhere.

    `library` are the tiles of Retrieve, `crop_pool` crops of other houses (None without).
    """

    house: str
    dataset: str
    scene: Path
    crops: Path
    embeddings: Path
    library: Path
    crop_pool: Path | None = None

    @classmethod
    def of(cls, paths: Mapping[str, str], house: str, dataset: str) -> HouseFiles:
        """Return the files among a job's inputs; `pool` is there where crops are pooled."""
        return cls(
            house,
            dataset,
            scene=Path(paths["scene"]),
            crops=Path(paths["crops"]),
            embeddings=Path(paths["embeddings"]),
            library=Path(paths["library"]),
            crop_pool=Path(paths["pool"]) if paths.get("pool") else None,
        )


@dataclass(frozen=True)
class Models:
    """Weights of all stages; `features` are those of FID and KID, `substances` of SUBS."""

    texture: Path
    naivesynth: Path
    propagation: Path
    features: Path
    substances: Path

    @classmethod
    def of(cls, paths: Mapping[str, str]) -> Models:
        """Return the weights among a job's inputs."""
        return cls(**{field.name: Path(paths[field.name]) for field in fields(cls)})

    def decoder(self, method: str) -> Path | None:
        """Return the texture model of a method; None where nothing is decoded."""
        name = DECODERS.get(method)
        return getattr(self, name) if name else None


@dataclass(frozen=True)
class Textures:
    """How tiles are made: the global seed, pixels of a side, seam correction or not."""

    seed: int
    size_px: int
    seam_correction: bool


def propagated_at(
    files: HouseFiles, models: Models, hidden_photos: Collection[str], folder: Path
) -> tuple[Path, Path]:
    """Write ``surfaces.parquet`` and ``propagated.parquet`` to `folder`; return both paths."""
    surfaces, propagated = folder / "surfaces.parquet", folder / "propagated.parquet"
    select_surfaces(
        files.embeddings,
        files.crops,
        hidden_photos,
        surfaces,
        house=files.house,
        dataset=files.dataset,
    )
    propagated_from(surfaces, propagated, files, models)
    return surfaces, propagated


def propagated_from(surfaces: Path, output: Path, files: HouseFiles, models: Models) -> None:
    """Write the ``propagated.parquet`` of a table of surfaces to `output`."""
    propagate_house(
        files.scene,
        surfaces,
        output,
        house=files.house,
        dataset=files.dataset,
        propagation_model=models.propagation,
        texture_model=models.texture,
    )


def measured(
    method: str,
    propagated: Path,
    files: HouseFiles,
    models: Models,
    hidden_photos: Collection[str],
    folder: Path,
    *,
    textures: Textures,
    drop: str,
    decoder: Path | None = None,
    name: str | None = None,
) -> pd.DataFrame:
    """Return the metrics of one method's textures, the columns of ``metrics.parquet``.

    Parameters
    ----------
    folder : path
        Tiles are written below it.
    decoder : path, optional
        Weights to decode with; the method's when None.
    name : str, optional
        Stands in the column ``method``; the method itself when None.
    """
    name = name or method
    tiles, output = folder / f"{name}_textures", folder / f"{name}.parquet"
    make_textures(
        method,
        _measurable(propagated, files.crops, folder / f"{name}_measurable.parquet"),
        files.crops,
        files.scene,
        tiles,
        house=files.house,
        hidden_photos=hidden_photos,
        library=files.library,
        model=decoder or models.decoder(method),
        seed=textures.seed,
        size_px=textures.size_px,
        seam_correction=textures.seam_correction,
        crop_pool=files.crop_pool,
    )
    measure_house(
        tiles,
        read_references(files.crops, hidden_photos),
        models.features,
        output,
        dataset=files.dataset,
        house=files.house,
        method=name,
        drop=drop,
        substance_model=models.substances,
    )
    return read_parquet(output)[0]


def metadata_of(files: HouseFiles, models: Models) -> dict[str, str]:
    """Return the metadata of a file of metrics: the house, and the networks behind them."""
    return {
        "dataset": files.dataset,
        "house": files.house,
        "features": network_name(models.features),
        "model": file_hash(models.features),
        "substances": network_name(models.substances),
        "substance_model": file_hash(models.substances),
    }


def _measurable(propagated: Path, crops: Path, output: Path) -> Path:
    """Write the rows of ``propagated.parquet`` that any crop shows; return the path.

    The others have no reference: their tiles would be made and looked at by nobody.
    """
    frame, metadata = read_parquet(propagated)
    shown = read_parquet(crops)[0][["room_id", "surface"]].drop_duplicates()
    kept = frame.merge(shown, on=["room_id", "surface"], how="inner")
    write_parquet(output, kept, metadata)
    return output
