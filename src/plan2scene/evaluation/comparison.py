"""One house by all methods of the paper's table: their textures, and the metrics of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from plan2scene.evaluation.houses import HouseFiles, Models
from plan2scene.evaluation.measure import measure_house, read_references
from plan2scene.evaluation.resampling import FurtherSeeds
from plan2scene.textures.methods import EMBEDDING_COLUMNS
from plan2scene.textures.stage import make_textures


@dataclass(frozen=True)
class Visible:
    """What a house shows at one drop fraction: its embeddings, and the photos that are hidden."""

    propagated: Path
    hidden_photos: Sequence[str]


@dataclass(frozen=True)
class Compared:
    """A method at a drop fraction (``"0.6"``): where its textures and its metrics are.

    `made` says that the textures are there; else they are written.
    """

    method: str
    drop: str
    textures: Path
    metrics: Path
    made: bool


@dataclass(frozen=True)
class Settings:
    """Global seed, pixels of a side, methods whose seams are corrected, images per surface."""

    seed: int
    size_px: int
    seam_correction: Mapping[str, bool]
    images: int = 1


def compare_house(
    files: HouseFiles,
    models: Models,
    drops: Mapping[str, Visible],
    compared: Sequence[Compared],
    settings: Settings,
) -> None:
    """Write the textures of every compared method, and ``metrics.parquet`` of each."""
    references = {
        drop: read_references(files.crops, visible.hidden_photos) for drop, visible in drops.items()
    }
    for one in compared:
        visible = drops[one.drop]
        if not one.made:
            _make(one, files, models, visible, settings)
        measure_house(
            one.textures,
            references[one.drop],
            models.features,
            one.metrics,
            dataset=files.dataset,
            house=files.house,
            method=one.method,
            drop=one.drop,
            substance_model=models.substances,
            further=_further(one, models, visible, settings),
        )


def _make(
    one: Compared, files: HouseFiles, models: Models, visible: Visible, settings: Settings
) -> None:
    """Write the textures of a method."""
    make_textures(
        one.method,
        visible.propagated,
        files.crops,
        files.scene,
        one.textures,
        house=files.house,
        hidden_photos=visible.hidden_photos,
        library=files.library,
        model=models.decoder(one.method),
        seed=settings.seed,
        size_px=settings.size_px,
        seam_correction=settings.seam_correction[one.method],
        crop_pool=files.crop_pool,
    )


def _further(
    one: Compared, models: Models, visible: Visible, settings: Settings
) -> FurtherSeeds | None:
    """Return what more images are decoded from; None for a method that has one image."""
    decoder = models.decoder(one.method)
    if settings.images < 2 or one.method not in EMBEDDING_COLUMNS or decoder is None:
        return None
    return FurtherSeeds(
        propagated=visible.propagated,
        model=decoder,
        count=settings.images,
        seed=settings.seed,
        size_px=settings.size_px,
        seam_correction=settings.seam_correction[one.method],
    )
