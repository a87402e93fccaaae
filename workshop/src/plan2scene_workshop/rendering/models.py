"""Furniture from a folder of GLB models with an index: they are read, simplified and cached.

The folder holds `index.csv` with the columns file, class, width, depth, height (metres), mount
(floor, wall, ceiling or table). Models are in metres, y up, front +z, origin at the floor's centre.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from plan2scene.errors import InputError
from plan2scene.io import safe_join
from plan2scene_workshop.rendering.geometry import Array, Colour, Solid
from plan2scene_workshop.rendering.index import index_path, of_split, read_index
from plan2scene_workshop.rendering.pieces import Piece
from plan2scene_workshop.rendering.tracer import Finish

MOUNTS = ("floor", "wall", "ceiling", "table")
#: Limits of a model: faces and texture side are reduced to them; more bytes or metres are refused.
MAX_FACES, MAX_TEXTURE_PX, MAX_BYTES, MAX_METRES = 9000, 256, 64 * 2**20, 6.0
_COLUMNS = ("file", "class", "mount", "width", "depth", "height")


@dataclass(frozen=True)
class ModelEntry:
    """A row of the index."""

    file: Path
    name: str
    kind: str  #: the column class
    mount: str
    size: tuple[float, float, float]  #: width, depth, height in metres


@dataclass(frozen=True, eq=False)
class ModelPart:
    """A mesh with one texture or colour."""

    solid: Solid  #: UVs in tiles, v down
    tile: NDArray[np.uint8] | None
    colour: Colour  #: linear; used if there is no tile


def read_model_index(folder: str | Path, *, train: bool) -> dict[str, list[ModelEntry]]:
    """Return the models of a folder by class, those of the train split or of the other splits.

    InputError if the index lacks a column or has a bad row.
    """
    index = index_path(folder)
    entries = [_entry(index.parent, row, index) for row in read_index(folder, "models", _COLUMNS)]
    found: dict[str, list[ModelEntry]] = {}
    for entry in of_split(entries, train=train):
        found.setdefault(entry.kind, []).append(entry)
    return found


def _entry(folder: Path, row: Mapping[str, str], index: Path) -> ModelEntry:
    try:
        size = (float(row["width"]), float(row["depth"]), float(row["height"]))
    except (TypeError, ValueError) as error:
        raise InputError("a model's size in metres", str(error), file=index) from error
    if not all(0 < side <= MAX_METRES for side in size):
        raise InputError(f"sizes of 0 to {MAX_METRES} m", str(size), file=index)
    if row["mount"] not in MOUNTS:
        raise InputError(f"a mount of {', '.join(MOUNTS)}", str(row["mount"]), file=index)
    name = Path(row["file"]).stem
    return ModelEntry(safe_join(folder, row["file"]), name, row["class"], row["mount"], size)


@lru_cache(maxsize=1024)
def load_model(file: Path) -> tuple[ModelPart, ...]:
    """Return the parts of a GLB file, simplified to :data:`MAX_FACES`; InputError if it is bad."""
    import trimesh

    try:
        if file.stat().st_size > MAX_BYTES:
            raise InputError(f"at most {MAX_BYTES} bytes", str(file.stat().st_size), file=file)
        with file.open("rb") as handle:  # a stream: nothing outside the file is opened
            scene: Any = trimesh.load_scene(handle, file_type="glb", process=False)
        meshes = [
            (scene.geometry[scene.graph[node][1]], np.asarray(scene.graph[node][0]))
            for node in sorted(scene.graph.nodes_geometry)
        ]
    except InputError:
        raise
    except Exception as error:  # a reader of unknown files may raise anything
        raise InputError("a GLB model", f"{type(error).__name__}: {error}", file=file) from error
    meshes = [(m, t) for m, t in meshes if isinstance(m, trimesh.Trimesh) and len(m.faces)]
    total = sum(len(mesh.faces) for mesh, _ in meshes)
    parts = tuple(_part(mesh, matrix, min(1.0, MAX_FACES / total)) for mesh, matrix in meshes)
    if not parts or not all(np.isfinite(part.solid.vertices).all() for part in parts):
        raise InputError("a GLB model with finite triangles", "none", file=file)
    return parts


def _part(mesh: Any, matrix: Array, share: float) -> ModelPart:
    uv = getattr(mesh.visual, "uv", None)
    material = getattr(mesh.visual, "material", None)
    uv = np.zeros((len(mesh.vertices), 2)) if uv is None else np.asarray(uv, float)
    solid = Solid(
        np.asarray(mesh.vertices, float),
        np.asarray(mesh.vertex_normals, float),
        np.stack([uv[:, 0], 1 - uv[:, 1]], -1),
        np.asarray(mesh.faces, np.int64),
    ).moved(matrix)
    if share < 1:
        solid = thinned(solid, int(len(solid.faces) * share))
    tile, colour = _look(material)
    small = Solid(
        solid.vertices.astype(np.float32),
        solid.normals.astype(np.float32),
        solid.uv.astype(np.float32),
        solid.faces.astype(np.int32),
    )
    return ModelPart(small, tile, colour)


def _look(material: Any) -> tuple[NDArray[np.uint8] | None, Colour]:
    """Return the texture, if any, and the linear colour of a glTF material."""
    factor = getattr(material, "baseColorFactor", None)
    values = np.ones(3) if factor is None else np.asarray(factor, float).ravel()[:3]
    values = values / 255 if values.max(initial=0) > 1 else values
    red, green, blue = (float(v) for v in np.clip(values, 0, 0.9))
    image = getattr(material, "baseColorTexture", None)
    if image is None:
        return None, (red, green, blue)
    pixels = np.array(image.convert("RGB"))
    scale = MAX_TEXTURE_PX / max(pixels.shape[:2])
    if scale < 1:
        size = tuple(max(1, round(side * scale)) for side in pixels.shape[1::-1])
        pixels = cv2.resize(pixels, size, interpolation=cv2.INTER_AREA)
    if factor is not None and values.min() < 0.98:
        pixels = (pixels * values ** (1 / 2.2)).astype(np.uint8)
    return np.ascontiguousarray(pixels, np.uint8), (red, green, blue)


def thinned(solid: Solid, limit: int) -> Solid:
    """Return the solid, simplified by vertex clustering on a grid to at most `limit` faces.

    The grid gets coarser until that holds. Of the vertices of a cell with normals in the same
    octant, only the first is kept.
    """
    low = solid.vertices.min(0)
    size = float((solid.vertices.max(0) - low).max())
    for cells in (160, 110, 75, 50, 34, 22, 14, 8):
        if len(solid.faces) <= limit:
            break
        octant = (solid.normals > 0) @ np.array([1, 2, 4])
        cell = np.floor((solid.vertices - low) / max(size, 1e-9) * cells).astype(np.int64)
        key = ((cell[:, 0] * 1024 + cell[:, 1]) * 1024 + cell[:, 2]) * 8 + octant
        _, first, inverse = np.unique(key, return_index=True, return_inverse=True)
        faces = first[inverse.ravel()[solid.faces]]
        a, b, c = faces.T
        faces = faces[(a != b) & (b != c) & (a != c)]
        used, renumbered = np.unique(faces, return_inverse=True)
        if not len(used):
            break
        solid = Solid(
            solid.vertices[used],
            solid.normals[used],
            solid.uv[used],
            renumbered.reshape(-1, 3).astype(np.int64),
        )
    return solid


class ModelShop:
    """The models that a scene can use, and the finishes of the models that it uses."""

    def __init__(self, index: Mapping[str, list[ModelEntry]]) -> None:
        self._index = index
        self.finishes: dict[str, Finish] = {}

    def has(self, kind: str, mounts: Collection[str] = MOUNTS) -> bool:
        """Return whether there is a model of a class."""
        return any(entry.mount in mounts for entry in self._index.get(kind, ()))

    def piece(
        self,
        rng: np.random.Generator,
        kind: str,
        *,
        mounts: Collection[str] = MOUNTS,
        skins: Collection[str] = (),
    ) -> Piece | None:
        """Return a model of a class as a piece with its back at z = 0; None if there is none.

        It is rescaled slightly. With `skins` (material names) most of its parts get one of these
        finishes with UVs in metres, and a random colour.
        """
        entries = [e for e in self._index.get(kind, ()) if e.mount in mounts]
        if not entries:
            return None
        entry = entries[int(rng.integers(len(entries)))]
        scale = np.exp(rng.normal(0, (0.08, 0.06, 0.08))) * rng.uniform(0.92, 1.08)
        width, depth, height = np.array(entry.size) * scale
        piece = Piece(float(width), float(depth), float(height))
        matrix = np.diag([scale[0], scale[2], scale[1], 1.0])
        matrix[2, 3] = depth / 2
        for k, part in enumerate(load_model(entry.file)):
            solid = part.solid.moved(matrix)
            if skins and rng.random() < 0.7:
                name, colour = str(rng.choice(list(skins))), tuple(rng.uniform(0.02, 0.8, 3))
                piece.parts.append((name, laid_over(solid), colour))
            elif part.tile is None:
                piece.parts.append(("model", solid, part.colour))
            else:
                name = f"model {entry.name} {k}"
                self.finishes[name] = Finish(part.tile, two_sided=True)
                piece.parts.append((name, solid, part.colour))
        return piece


def laid_over(solid: Solid) -> Solid:
    """Return the solid with UVs in metres, projected along the main axis of each normal."""
    axis = np.abs(solid.normals).argmax(1)
    u = np.where(axis == 0, solid.vertices[:, 2], solid.vertices[:, 0])
    v = np.where(axis == 1, solid.vertices[:, 2], -solid.vertices[:, 1])
    return Solid(solid.vertices, solid.normals, np.stack([u, v], -1), solid.faces)
