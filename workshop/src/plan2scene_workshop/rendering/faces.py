"""Attributes of each face for the quick renderer, and the split of emitters into parts."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plan2scene_workshop.rendering.geometry import JoinedGroup, Solid
from plan2scene_workshop.rendering.tracer import Finish

#: Number of emitters in every scene, so that one compiled kernel fits all. Missing ones are dark
#: specks far below the scene.
EMITTERS = 5


@dataclass(frozen=True)
class Faces:
    """Attributes of all m faces of a scene."""

    labels: NDArray[np.uint8]
    groups: NDArray[np.int32]  #: index into the tracer's `names`
    colours: NDArray[np.float32]  #: (m, 3) mean albedo, linear; zero of emitters
    emission: NDArray[np.float32]  #: (m, 3) linear


def radiance_of(finish: Finish) -> list[float]:
    """Return the linear RGB radiance of a finish; zero if it is no emitter."""
    return [float(finish.emission or 0.0) * c for c in finish.light]


def split_emitters(shining: list[tuple[Solid, list[float]]]) -> list[tuple[Solid, list[float]]]:
    """Return the emitters (solid, radiance); the strongest is halved until :data:`EMITTERS` exist.

    All emitters are sampled equally often, so dark ones in their place would waste paths.
    """
    parts = list(shining)
    while parts and len(parts) < EMITTERS:
        power = [sum(radiance) if len(solid.faces) > 1 else -1.0 for solid, radiance in parts]
        k = int(np.argmax(np.array(power) * [_area(solid) for solid, _ in parts]))
        solid, radiance = parts[k]
        if power[k] <= 0:
            break
        half = len(solid.faces) // 2
        parts[k : k + 1] = [
            (replace(solid, faces=faces), radiance)
            for faces in (solid.faces[:half], solid.faces[half:])
        ]
    return parts


def _area(solid: Solid) -> float:
    a, b, c = (solid.vertices[solid.faces[:, k]] for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def faces_of(rows: list[tuple[str, JoinedGroup, Finish]]) -> Faces:
    """Return the attributes of all faces, one group after another."""
    colours, emission = [], []
    for _, group, finish in rows:
        count = len(group.solid.faces)
        colour = group.colours
        if finish.tile is not None:
            colour = np.tile(((finish.tile / 255.0) ** 2.2).mean((0, 1)), (count, 1))
        shines = finish.emission is not None
        colours.append(np.zeros((count, 3)) if shines else np.clip(colour, 0.002, 0.9))
        emission.append(np.tile(radiance_of(finish), (count, 1)))
    counts = [len(group.solid.faces) for _, group, _ in rows]
    return Faces(
        np.concatenate([group.labels for _, group, _ in rows]),
        np.repeat(np.arange(len(rows), dtype=np.int32), counts),
        np.concatenate(colours).astype(np.float32),
        np.concatenate(emission).astype(np.float32),
    )


def uv_density(
    vertices: NDArray[Any], uv: NDArray[Any], faces: NDArray[Any]
) -> NDArray[np.float32]:
    """Return UV units per metre of each face: the square root of UV area over surface area."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    p, q, r = (uv[faces[:, k]] for k in range(3))
    d, e = q - p, r - p
    flat = np.abs(d[:, 0] * e[:, 1] - d[:, 1] * e[:, 0])
    return np.sqrt(flat / np.maximum(area, 1e-12)).astype(np.float32)
