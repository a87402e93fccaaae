"""A house that is evaluated: selection, propagation, textures and metrics in one process.

A sweep or an ablation repeats these steps dozens of times per house; as separate jobs they would
spend most of their time on starting processes. The functions are those of the stages, so the
results are the same.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plan2scene.evaluation.measure import Networks, measure_tiles
from plan2scene.evaluation.references import References
from plan2scene.propagation.propagate import propagate_house
from plan2scene.textures.house_textures import house_tiles
from plan2scene.textures.inputs import HouseData, HouseFiles, TextureSettings, Visible
from plan2scene.textures.observed_surfaces import select_surfaces

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Models(Networks):
    """The weights of all stages that the evaluation needs."""

    texture: Path
    naivesynth: Path
    propagation: Path

    @property
    def decoders(self) -> dict[str, Path]:
        """Return the weights by name, for texture methods."""
        return asdict(self)


@dataclass(frozen=True)
class EvaluatedHouse:
    """A house's files, the weights of all stages, and how its tables and tiles are made."""

    dataset: str
    files: HouseFiles
    models: Models
    settings: TextureSettings
    predictor: str  #: of unobserved surfaces, a name of ``propagation.predictors.PREDICTORS``
    colours: Path | None = None  #: the colours of all surfaces in the photos

    @classmethod
    def of(cls, paths: Mapping[str, Any], house_id: str, params: Any) -> EvaluatedHouse:
        """Return the house of a job: its inputs by name, and its params."""
        return cls(
            params.dataset,
            HouseFiles.of(paths, house_id),
            Models(**{field.name: Path(params.models[field.name]) for field in fields(Models)}),
            TextureSettings(params.seed, params.size_px, params.seam_correction),
            params.predictor,
            Path(paths["colours"]),
        )

    @property
    def metadata(self) -> dict[str, str]:
        """Return the metadata of a file of metrics: the house, and the networks of the metrics."""
        names = {"dataset": self.dataset, "house": self.files.house_id}
        return names | self.models.metadata

    def select(self, embeddings: Path, hidden_photos: Sequence[str], output: Path) -> pd.DataFrame:
        """Write the ``surfaces.parquet`` of the visible photos to `output`; return it."""
        files, dataset = self.files, self.dataset
        return select_surfaces(
            embeddings, files.crops, hidden_photos, output, house=files.house_id, dataset=dataset
        )

    def propagate(self, surfaces: Path, hidden_photos: Sequence[str], output: Path) -> None:
        """Write the ``propagated.parquet`` of a table of surfaces to `output`."""
        propagate_house(
            self.files.scene,
            surfaces,
            output,
            house=self.files.house_id,
            dataset=self.dataset,
            propagation_model=self.models.propagation,
            texture_model=self.models.texture,
            predictor=self.predictor,
            colours=self.colours,
            hidden_photos=hidden_photos,
        )


def measured_at(
    house: EvaluatedHouse,
    data: HouseData,
    visible: Visible,
    methods: Sequence[str],
    references: References,
    *,
    drop: str = "",
) -> list[pd.DataFrame]:
    """Return the metrics of several methods at one drop; tiles without a reference are not made."""
    inputs = data.at(visible, house.models.decoders, house.settings)
    surfaces = tuple(surface for surface in inputs.surfaces if surface.key in references)
    inputs = replace(inputs, surfaces=surfaces)
    observed = {surface.key for surface in inputs.surfaces if surface.observed}
    frames = []
    for method in methods:
        tiles = house_tiles(method, inputs)
        frames.append(
            measure_tiles(
                {key: tile.image for key, tile in tiles.items()},
                observed,
                references,
                house.models,
                house_id=house.files.house_id,
                method=method,
                drop=drop,
            )
        )
    return frames
