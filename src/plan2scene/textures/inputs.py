"""The inputs of texture methods: the files of a house, each read when it is first needed."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plan2scene.errors import InputError
from plan2scene.house import House, SurfaceKey
from plan2scene.io import read_parquet
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.textures.crops import Crop, PoolCrop, read_pool
from plan2scene.textures.library import TextureLibrary, read_library

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class HouseFiles:
    """Files of one house that do not depend on the drop (share of hidden photos), and shared files.

    `library` holds the tiles of Retrieve, `crop_pool` crops of other houses, `patterns` those of
    floors; None where there is none.
    """

    house_id: str
    scene: Path
    crops: Path
    library: Path | None = None
    crop_pool: Path | None = None
    patterns: Path | None = None

    @classmethod
    def of(cls, paths: Mapping[str, Any], house_id: str) -> HouseFiles:
        """Return the files from a job's inputs: scene, crops and, where given, the others."""
        names = ("library", "pool", "patterns")
        others = (Path(paths[name]) if paths.get(name) else None for name in names)
        return cls(house_id, Path(paths["scene"]), Path(paths["crops"]), *others)


@dataclass(frozen=True)
class Visible:
    """What is visible of a house at one drop: ``propagated.parquet`` and the hidden photos."""

    propagated: Path
    hidden_photos: Sequence[str] = ()


@dataclass(frozen=True)
class TextureSettings:
    """Global seed, pixels of a tile's side, whether each method's seams are corrected, threads.

    A method that is not in `seam_correction` has the registry's default. `threads` is the number of
    materials that are made at a time; tiles do not depend on it.
    """

    seed: int
    size_px: int
    seam_correction: Mapping[str, bool] = field(default_factory=dict)
    threads: int = 1


@dataclass(frozen=True, eq=False)
class KnownSurface:
    """What is known of a surface, a row of ``propagated.parquet``.

    `embedding` (11,) and `naive_embedding` (8,) are float32, None where not computed. `size_m` is
    the metres that its tile's side covers, `source` the crop or the propagation that the embedding
    comes from, `material` the name of the material that it shares with other rooms (or empty).
    `colour` (3,) is its sRGB colour from all photos together, None where that is not known.
    """

    key: SurfaceKey
    observed: bool
    size_m: float
    substance: str
    source: str
    confidence: float
    embedding: np.ndarray | None
    naive_embedding: np.ndarray | None
    material: str = ""
    colour: np.ndarray | None = None

    @classmethod
    def of(cls, row: Any) -> KnownSurface:
        """Return the surface of a row (a named tuple)."""
        return cls(
            SurfaceKey(row.room_id, row.surface),
            bool(row.observed),
            float(row.metres),
            row.substance,
            str(row.source),
            float(row.confidence),
            np.asarray(row.embedding, dtype=np.float32),
            np.asarray(row.naive_embedding, dtype=np.float32),
            row.material,
            np.asarray(row.colour, dtype=np.float64) if hasattr(row, "colour") else None,
        )

    @property
    def tone(self) -> np.ndarray | None:
        """Return the surface's colour (3,) sRGB from all photos, else from its embedding."""
        if self.colour is not None:
            return np.clip(self.colour, 0.0, 1.0)
        if self.embedding is None:
            return None
        return np.clip(self.embedding[-3:].astype(np.float64), 0.0, 1.0)


class HouseData:
    """The plan and tables of :class:`HouseFiles`, each read once, when it is first needed.

    `exemplars` and `decoded` cache what was made: many surfaces have the same crops, or the same
    embedding, at several drops and in several methods.
    """

    def __init__(self, files: HouseFiles) -> None:
        self.files = files
        self.exemplars: dict[Hashable, Any] = {}
        self.decoded: dict[Hashable, tuple[np.ndarray, bool]] = {}  #: image, whether it tiles

    @cached_property
    def house(self) -> House:
        """The plan."""
        return read_scene_json(self.files.scene, self.files.house_id)

    @cached_property
    def crops(self) -> pd.DataFrame:
        """``crops.parquet``, including the crops of hidden photos."""
        return read_parquet(self.files.crops)[0]

    @cached_property
    def library(self) -> TextureLibrary:
        """The tiles to retrieve from."""
        if self.files.library is None:
            raise InputError("a texture library", "none", house=self.files.house_id)
        return read_library(self.files.library)

    @cached_property
    def pool(self) -> list[PoolCrop]:
        """Crops of other houses; empty without a pool."""
        path = self.files.crop_pool
        return read_pool(path, but=self.files.house_id) if path else []

    def at(
        self, visible: Visible, models: Mapping[str, Path], settings: TextureSettings
    ) -> TextureInputs:
        """Return the inputs of a texture method at a drop."""
        hidden = set(visible.hidden_photos)
        rows = read_parquet(visible.propagated)[0].itertuples()
        crops = (Crop.of(row) for row in self.crops.itertuples() if row.photo not in hidden)
        surfaces = tuple(KnownSurface.of(row) for row in rows)
        return TextureInputs(self, surfaces, tuple(crops), models, settings)


@dataclass(frozen=True, eq=False)
class TextureInputs:
    """The inputs from which a method makes tiles."""

    data: HouseData  #: gives the plan, the library and the crops of other houses
    surfaces: tuple[KnownSurface, ...]  #: those that need a tile
    crops: tuple[Crop, ...]  #: of visible photos, in the file's order
    models: Mapping[str, Path]  #: weight files by name (``texture``, ``naivesynth``)
    settings: TextureSettings

    @property
    def house(self) -> House:
        """The plan."""
        return self.data.house
