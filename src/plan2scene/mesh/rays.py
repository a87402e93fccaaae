"""Ray casting against a house with Embree; rays pass through glass."""

from __future__ import annotations

import logging
from collections.abc import Sequence

import numpy as np
import trimesh

from plan2scene.mesh.parts import MeshPart


class Rays:
    """The opaque parts of a house as one set of triangles that rays are cast against.

    `triangles` is (t, 3, 3) float64 of all `parts`, one after another; `part` (t,) int is the
    number of each triangle's part, `face` (t,) int its number within the part.
    """

    def __init__(self, parts: Sequence[MeshPart]) -> None:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        self.parts = list(parts)
        self.triangles = np.concatenate([part.mesh.triangles for part in parts])
        counts = [len(part.mesh.faces) for part in parts]
        self.part = np.repeat(np.arange(len(parts)), counts)
        self.face = np.concatenate([np.arange(count) for count in counts])
        self._scene = EmbreeScene()
        TriangleMesh(self._scene, np.ascontiguousarray(self.triangles, dtype=np.float32))

    @classmethod
    def of(cls, parts: Sequence[MeshPart]) -> Rays | None:
        """Return rays against the opaque parts; None, with a warning, without a ray tracer."""
        try:
            return cls([part for part in parts if part.material != "glass"])
        except ImportError:
            logging.getLogger("plan2scene").warning("no Embree here: the house has no occlusion")
            return None

    def distances(self, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Return the distances (n,), metres, at which rays (n, 3) hit something; large if never."""
        ends = origins.astype(np.float32), directions.astype(np.float32)
        return np.asarray(self._scene.run(*ends, query="DISTANCE"))

    def hits(self, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Return the triangle that each ray (n, 3) hits first, (n,) int; -1 for none."""
        ends = origins.astype(np.float32), directions.astype(np.float32)
        return np.asarray(self._scene.run(*ends))

    def points(
        self, triangles: np.ndarray, origins: np.ndarray, directions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return where rays meet the planes of their triangles (n,): points (n, 3), metres (n,)."""
        corner = self.triangles[triangles]
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        along = np.einsum("ij,ij->i", directions, normal)
        away = np.einsum("ij,ij->i", corner[:, 0] - origins, normal)
        distance = away / np.where(np.abs(along) < 1e-12, 1e-12, along)
        return origins + distance[:, None] * directions, distance


def hemisphere(normal: np.ndarray, count: int, shift: float = 0.0) -> np.ndarray:
    """Return unit directions about a normal, (count, 3), of cosine density (Malley's method).

    They lie on a spiral. `shift` (-.5 to .5) moves them along it by this share of a step.
    """
    number = np.arange(count) + shift
    radius = np.sqrt((number + 0.5) / count)
    angle = number * np.pi * (3 - np.sqrt(5))
    local = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1 - radius**2)], 1)
    turn = trimesh.geometry.align_vectors([0, 0, 1], normal)[:3, :3]
    return np.asarray(local @ turn.T)
