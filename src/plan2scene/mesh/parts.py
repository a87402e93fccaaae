"""Mesh parts: named, single-material triangle meshes, and a builder for quads and boxes.

World axes of ``docs/conventions.md``: metres, y up, right-handed; plan points are (x, z).
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
import trimesh
from shapely.geometry.base import BaseGeometry

from plan2scene.house import SurfaceKey
from plan2scene.mesh.polygons import triangulate

Colour = tuple[int, int, int]  #: sRGB, 0..255
Corner = tuple[float, float, float]
WHITE: Colour = (255, 255, 255)
GLASS = (0.62, 0.75, 0.80, 0.28)  #: Linear base colour and opacity of window glass
#: Vertices are rounded to this many decimals of a metre, so that faces that meet at an edge share
#: it exactly also in float32: otherwise light shines through the crack.
GRID_DECIMALS = 5


@dataclass(frozen=True)
class MeshPart:
    """One named node of the house with one material.

    The mesh is in metres. It has n vertices with unit normals, not shared between faces of
    different planes. Faces are counter-clockwise seen from the visible side.
    """

    name: str  #: ``{room}/floor``, ``{room}/wall/{wall}``, ``structure/wall/{wall}`` ...
    mesh: trimesh.Trimesh
    material: str  #: ``surface`` (a room surface's texture), ``plain`` (vertex colours), ``glass``
    surface: SurfaceKey | None = None  #: the texture of a ``surface`` part
    #: (n, 2) float64, metres: divide by the tile's size; v down the image
    uv: np.ndarray | None = None
    colours: np.ndarray | None = None  #: (n, 3) uint8 sRGB of a ``plain`` part's vertices
    #: what viewers show: room id, kind of part, wall or opening id
    extras: Mapping[str, object] = field(default_factory=dict)

    def uv_to_world(self) -> np.ndarray:
        """Return the (3, 3) float64 matrix from rows (u, v, 1) on a flat part to world metres."""
        homogeneous_uv = np.column_stack([np.asarray(self.uv), np.ones(len(self.mesh.vertices))])
        return np.asarray(np.linalg.lstsq(homogeneous_uv, self.mesh.vertices, rcond=None)[0])


def numbered(names: Iterable[str]) -> list[str]:
    """Return unique names: a repeated one gets ``#2``, ``#3`` ... at its end."""
    seen: Counter[str] = Counter()
    result = []
    for name in names:
        seen[name] += 1
        result.append(name if seen[name] == 1 else f"{name}#{seen[name]}")
    return result


def flat_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return (n, 3) unit vertex normals of a mesh whose faces share vertices only in a plane.

    Faces are weighted by area, unlike in trimesh, so that slivers do not count. A vertex whose
    faces have no area gets the normal (0, 1, 0).
    """
    cross = trimesh.triangles.cross(vertices[faces])
    normals = trimesh.geometry.mean_vertex_normals(len(vertices), faces, cross)
    return np.where(normals.any(axis=1, keepdims=True), normals, [0.0, 1.0, 0.0])


class PartBuilder:
    """Collects quads, boxes and flat meshes with colours or UVs into one `MeshPart`."""

    def __init__(self) -> None:
        self._pieces: list[tuple[np.ndarray, ...]] = []
        self._count = 0

    def __bool__(self) -> bool:
        """Return whether anything was added."""
        return bool(self._pieces)

    def mesh(
        self,
        vertices: np.ndarray,
        faces: np.ndarray,
        *,
        colour: Colour | np.ndarray = WHITE,
        uv: np.ndarray | None = None,
    ) -> None:
        """Add a flat mesh: (n, 3) vertices, (m, 3) faces, optionally (n, 2) UVs in metres.

        `colour` is one for all vertices, or (n, 3) uint8.
        """
        if len(faces) == 0:
            return
        n = len(vertices)
        colours = np.broadcast_to(np.array(colour, dtype=np.uint8), (n, 3))
        uv = np.zeros((n, 2)) if uv is None else uv
        self._pieces.append((vertices, faces + self._count, colours, uv))
        self._count += n

    def level(
        self, area: BaseGeometry, y: float, *, up: bool = True, colour: Colour = WHITE
    ) -> None:
        """Add a plan polygon at height `y` that faces up or down; UV = (x, z) in metres."""
        points, faces = triangulate(area)
        turned = faces[:, ::-1] if up else faces
        self.mesh(np.insert(points, 1, y, axis=1), turned, colour=colour, uv=points)

    def quad(self, corners: np.ndarray, colour: Colour, uv: np.ndarray | None = None) -> None:
        """Add a quad: (4, 3) corners counter-clockwise seen from the visible side."""
        self.mesh(np.asarray(corners), np.array([[0, 1, 2], [0, 2, 3]]), colour=colour, uv=uv)

    def box(self, frame: np.ndarray, low: Corner, high: Corner, colour: Colour) -> None:
        """Add a box between two opposite corners of a local frame, metres.

        `frame` is (4, 3) float: right-handed orthonormal axes in rows 0-2, the origin in row 3.
        """
        corners = np.array(list(itertools.product(*zip(low, high, strict=True))))
        points = corners @ frame[:3] + frame[3]
        for face in _BOX_FACES:
            self.quad(points[list(face)], colour)

    def build(
        self,
        name: str,
        material: str = "plain",
        surface: SurfaceKey | None = None,
        extras: Mapping[str, object] | None = None,
    ) -> MeshPart:
        """Return what was added as one part."""
        vertices, faces, colours, uv = map(np.concatenate, zip(*self._pieces, strict=True))
        vertices = np.round(vertices, GRID_DECIMALS)
        normals = flat_normals(vertices, faces)
        return MeshPart(
            name=name,
            mesh=trimesh.Trimesh(vertices, faces, vertex_normals=normals, process=False),
            material=material,
            surface=surface,
            uv=uv if material == "surface" else None,
            colours=colours if material == "plain" else None,
            extras=dict(extras or {}),
        )


# Corner index = 4 x + 2 y + z; each face counter-clockwise seen from outside. (trimesh's box shares
# its corners between sides; here each side has normals of its own.)
_BOX_FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
