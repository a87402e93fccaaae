"""Real data that training photos use besides procedural data: textures, environments, models."""

from __future__ import annotations

import importlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from plan2scene.errors import InputError
from plan2scene.images import read_image
from plan2scene.io import safe_join
from plan2scene.materials import Material
from plan2scene.seeds import generator
from plan2scene_workshop.rendering.index import (
    index_path,
    of_split,
    read_index,
    textures_of_split,
)
from plan2scene_workshop.rendering.lights import PANORAMA_TOP
from plan2scene_workshop.rendering.models import ModelEntry, read_model_index

#: Substance, size in metres and roughness by the last word of a row's column substance.
_SUBSTANCES = {
    "carpet": ("carpet", 0.8, 0.97),
    "fabric": ("carpet", 0.5, 0.97),
    "concrete": ("plaster", 2.0, 0.7),
    "plaster": ("plaster", 1.8, 0.9),
    "wallpaper": ("plaster", 0.8, 0.9),
    "brick": ("tile", 1.4, 0.8),
    "tile": ("tile", 1.4, 0.3),
    "marble": ("tile", 1.4, 0.2),
    "wood": ("wood", 1.6, 0.45),
    "laminate": ("wood", 1.6, 0.4),
    "veneer": ("wood", 1.0, 0.4),
}
#: Side in pixels to which flat textures are resized.
TEXTURE_PX = 512


@dataclass(frozen=True)
class Environment:
    """The view outside windows, and the colour of its light."""

    panorama: NDArray[np.float32]  #: in the format of :func:`.lights.view_outside`
    tint: tuple[float, float, float]  #: linear RGB with mean 1: mean colour of the upper half


@dataclass(frozen=True)
class Sources:
    """All real data of one split; if empty, everything is procedural."""

    textures: Sequence[Material] = ()
    environments: Sequence[Environment] = ()
    models: Mapping[str, list[ModelEntry]] = field(default_factory=dict)


@lru_cache(maxsize=4)
def load_sources(
    textures: tuple[str, ...], environments: str | None, models: str | None, *, train: bool
) -> Sources:
    """Return the folders' data for the train split, or the different data for the other splits."""
    materials: list[Material] = []
    for folder in textures:
        materials += load_textures(folder, train=train)
    return Sources(
        materials,
        load_environments(environments, train=train) if environments else (),
        read_model_index(models, train=train) if models else {},
    )


def load_textures(folder: str | Path, *, train: bool) -> list[Material]:
    """Return the textures of a folder, which has subfolders per substance, or is flat.

    A flat folder has `index.csv` with columns file and substance (such as floor_wood). Column
    normal may name a normal map: its shading by light from one side is added to the colour. Every
    eighth row is for the splits other than train.
    """
    rows = read_index(folder, "textures")
    if "file" not in rows[0]:
        return textures_of_split(folder, "train" if train else "val")
    if "substance" not in rows[0]:
        raise InputError(
            "columns file and substance", ", ".join(map(str, rows[0])), file=index_path(folder)
        )
    return [_flat_texture(Path(folder), row) for row in of_split(rows, train=train)]


def _flat_texture(folder: Path, row: Mapping[str, str]) -> Material:
    word = row["substance"].split("_")[-1]
    if word not in _SUBSTANCES:
        expected = f"a substance of {', '.join(_SUBSTANCES)}"
        raise InputError(expected, row["substance"], file=index_path(folder))
    substance, size_m, roughness = _SUBSTANCES[word]
    image = _square(read_image(safe_join(folder, row["file"])))
    if row.get("normal"):
        normals = _square(read_image(safe_join(folder, row["normal"]))).astype(np.float32)
        angle = generator(0, "relief", row["file"]).uniform(0, 2 * np.pi)
        slope = (normals[..., :2] / 127.5 - 1) @ np.array([np.cos(angle), np.sin(angle)])
        image = np.clip(image * (1 + 0.5 * slope[..., None]), 0, 255).astype(np.uint8)
    name = f"scan-{Path(row['file']).stem}"
    return Material(name, substance, word, image, size_m, roughness)


def _square(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    side = (TEXTURE_PX, TEXTURE_PX)
    return np.ascontiguousarray(cv2.resize(image, side, interpolation=cv2.INTER_AREA))


def load_environments(folder: str | Path, *, train: bool) -> list[Environment]:
    """Return the environments of a folder (`index.csv` with column file, equirectangular HDR)."""
    rows = of_split(read_index(folder, "environments", ("file",)), train=train)
    return [_environment(safe_join(folder, row["file"])) for row in rows]


def _environment(file: Path) -> Environment:
    from plan2scene_workshop.rendering.tracer import load_mitsuba

    mi: Any = load_mitsuba()
    drjit = importlib.import_module("drjit")
    drjit.set_thread_count(max(2, drjit.thread_count()))  # the EXR reader hangs with one
    try:
        bitmap = mi.Bitmap(str(file)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32)
    except RuntimeError as error:
        raise InputError("an HDR or EXR image", str(error), file=file) from error
    image = np.nan_to_num(np.array(bitmap, np.float32))
    rows = image.shape[0]
    cut = int(rows * (0.5 - PANORAMA_TOP / np.pi))
    view = cv2.resize(image[cut : rows - cut], (1024, 256), interpolation=cv2.INTER_AREA)
    tint = np.clip(image[: rows // 2].mean((0, 1)), 1e-3, None)
    red, green, blue = (float(c) for c in tint / tint.mean())
    median = float(np.percentile(view.mean(-1), 70))
    return Environment(np.minimum(view / max(median, 1e-3), 6.0), (red, green, blue))
