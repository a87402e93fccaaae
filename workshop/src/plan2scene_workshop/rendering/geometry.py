"""Triangle meshes with the attributes for rendering and truth: material, colour, label, plane."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plan2scene.photos.labels.palette import OTHER

#: Plane index of a triangle that lies on no labelled plane.
NO_PLANE = 255

Array = NDArray[np.float64]
Colour = tuple[float, float, float]  #: linear RGB in [0, 1]


@dataclass(frozen=True)
class Solid:
    """A triangle mesh in metres, in any frame."""

    vertices: Array  #: (n, 3)
    normals: Array  #: (n, 3), per vertex; flat faces have their own vertices
    uv: Array  #: (n, 2) along the surface, v down; the tracer divides by the tile's size
    faces: NDArray[np.int64]  #: (m, 3)

    def moved(self, matrix: Array) -> Solid:
        """Return the solid under a 4x4 rigid or scaling transform (metric UVs unchanged)."""
        linear = matrix[:3, :3]
        normals = self.normals @ np.linalg.inv(linear)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
        vertices = self.vertices @ linear.T + matrix[:3, 3]
        return Solid(vertices, normals, self.uv, self.faces)


@dataclass(frozen=True)
class JoinedGroup:
    """The mesh of one material, with colour (m, 3), label (m,) and plane (m,) of each face."""

    solid: Solid
    colours: Array
    labels: NDArray[np.uint8]
    planes: NDArray[np.uint8]


class Geometry:
    """Solids grouped by the name of their material."""

    def __init__(self) -> None:
        self._parts: dict[str, list[tuple[Solid, Colour, int, int]]] = {}

    def add(
        self,
        material: str,
        solid: Solid,
        *,
        colour: Colour = (0.5, 0.5, 0.5),
        label: int = OTHER,
        plane: int = NO_PLANE,
    ) -> None:
        """Add a solid; `colour` is used only by materials with a colour per face."""
        self._parts.setdefault(material, []).append((solid, colour, label, plane))

    def unfurnished(self) -> Geometry:
        """Return the solids with a label: floors, walls, ceilings, doors, closets and windows."""
        bare = Geometry()
        for name, parts in self._parts.items():
            if own := [part for part in parts if part[2] != OTHER]:
                bare._parts[name] = own
        return bare

    def joined(self) -> dict[str, JoinedGroup]:
        """Return one mesh per material, in order of material name."""
        return {name: _join(parts) for name, parts in sorted(self._parts.items())}


def _join(parts: Sequence[tuple[Solid, Colour, int, int]]) -> JoinedGroup:
    solids, colours, labels, planes = zip(*parts, strict=True)
    counts = [len(solid.faces) for solid in solids]
    return JoinedGroup(
        merge(solids),
        np.repeat(np.array(colours, float), counts, axis=0),
        np.repeat(np.array(labels, np.uint8), counts),
        np.repeat(np.array(planes, np.uint8), counts),
    )


def merge(solids: Sequence[Solid]) -> Solid:
    """Return all solids as one."""
    starts = np.cumsum([0] + [len(solid.vertices) for solid in solids])
    return Solid(
        np.concatenate([solid.vertices for solid in solids]),
        np.concatenate([solid.normals for solid in solids]),
        np.concatenate([solid.uv for solid in solids]),
        np.concatenate([s.faces + start for s, start in zip(solids, starts, strict=False)]),
    )


def quad(
    corner: Array, right: Array, down: Array, uv_origin: tuple[float, float] = (0, 0)
) -> Solid:
    """Return a rectangle whose front side shows `right` to the right and `down` downwards.

    UVs are metres from `corner` plus `uv_origin`.
    """
    corner, right, down = (np.asarray(v, float) for v in (corner, right, down))
    vertices = np.array([corner, corner + right, corner + right + down, corner + down])
    normal = np.cross(down, right)
    normal = normal / max(float(np.linalg.norm(normal)), 1e-12)
    width, height = float(np.linalg.norm(right)), float(np.linalg.norm(down))
    uv = np.array([[0, 0], [width, 0], [width, height], [0, height]]) + np.array(uv_origin)
    faces = np.array([[0, 2, 1], [0, 3, 2]])
    return Solid(vertices, np.tile(normal, (4, 1)), uv, faces)


def box(low: Sequence[float], high: Sequence[float]) -> Solid:
    """Return an axis-aligned box with outward faces; UVs in metres on each side."""
    x0, y0, z0 = low
    x1, y1, z1 = high
    w, h, d = x1 - x0, y1 - y0, z1 - z0

    def side(corner: Sequence[float], right: Sequence[float], down: Sequence[float]) -> Solid:
        return quad(np.array(corner), np.array(right), np.array(down))

    return merge(
        [
            side((x0, y1, z1), (w, 0, 0), (0, -h, 0)),
            side((x1, y1, z0), (-w, 0, 0), (0, -h, 0)),
            side((x1, y1, z1), (0, 0, -d), (0, -h, 0)),
            side((x0, y1, z0), (0, 0, d), (0, -h, 0)),
            side((x0, y1, z0), (w, 0, 0), (0, 0, d)),
            side((x0, y0, z1), (w, 0, 0), (0, 0, -d)),
        ]
    )


def superquadric(
    centre: Sequence[float],
    radii: Sequence[float],
    *,
    roundness: tuple[float, float] = (1.0, 1.0),
    steps: tuple[int, int] = (8, 16),
) -> Solid:
    """Return a superellipsoid: with roundness 1 an ellipsoid, near 0 a box with rounded edges.

    `roundness` is the (vertical, horizontal) exponents of Barr (1981), `steps` is (rows, columns).
    """
    rows, columns = steps
    eta = np.linspace(-np.pi / 2, np.pi / 2, rows + 1)
    omega = np.linspace(0, 2 * np.pi, columns + 1)
    e1, e2 = roundness

    def power(values: Array, exponent: float) -> Array:
        return np.sign(values) * np.abs(values) ** exponent

    ce, se = np.cos(eta)[:, None], np.sin(eta)[:, None] * np.ones_like(omega)
    co, so = np.cos(omega)[None], np.sin(omega)[None]
    a, b, c = radii
    points = np.stack(
        [a * power(ce, e1) * power(co, e2), b * power(se, e1), c * power(ce, e1) * power(so, e2)],
        -1,
    )
    normals = np.stack(
        [
            power(ce, 2 - e1) * power(co, 2 - e2) / a,
            power(se, 2 - e1) / b,
            power(ce, 2 - e1) * power(so, 2 - e2) / c,
        ],
        -1,
    ).reshape(-1, 3)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-9)
    around, along = np.meshgrid(omega * (a + c) / 2, -eta * b)
    uv = np.stack([around, along], -1).reshape(-1, 2)
    vertices = points.reshape(-1, 3) + np.asarray(centre, float)
    return Solid(vertices, normals, uv, _grid_faces(rows, columns))


def lathe(
    centre: Sequence[float], profile: Sequence[tuple[float, float]], steps: int = 20
) -> Solid:
    """Return the surface of revolution about y of (radius, height) pairs, from bottom to top."""
    radius, height = np.array(profile, float).T
    omega = np.linspace(0, 2 * np.pi, steps + 1)
    parts = []
    for i in range(len(radius) - 1):
        slope = np.array([height[i + 1] - height[i], -(radius[i + 1] - radius[i])])
        slope = slope / max(float(np.hypot(*slope)), 1e-12)
        ring = np.stack([np.cos(omega), np.zeros_like(omega), np.sin(omega)], -1)
        lower = ring * radius[i] + [0, height[i], 0]
        upper = ring * radius[i + 1] + [0, height[i + 1], 0]
        normals = ring * slope[0] + [0, slope[1], 0]
        around = omega * max(radius[i], radius[i + 1])
        uv = np.concatenate(
            [np.stack([around, -np.full_like(omega, height[i + k])], -1) for k in (0, 1)]
        )
        vertices = np.concatenate([lower, upper]) + np.asarray(centre, float)
        parts.append(Solid(vertices, np.tile(normals, (2, 1)), uv, _grid_faces(1, steps)))
    return merge(parts)


def cylinder(base: Sequence[float], radius: float, height: float, steps: int = 16) -> Solid:
    """Return an upright closed cylinder standing at `base`."""
    return lathe(base, [(0, 0), (radius, 0), (radius, height), (0, height)], steps)


def _grid_faces(rows: int, columns: int) -> NDArray[np.int64]:
    """Return triangles of a (rows+1) x (columns+1) grid that face outwards for y-up grids."""
    i, j = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    a = (i * (columns + 1) + j).ravel()
    b, c, d = a + 1, a + columns + 2, a + columns + 1
    return np.concatenate([np.stack([a, c, b], -1), np.stack([a, d, c], -1)])


def placement(x: float, z: float, angle: float, y: float = 0.0) -> Array:
    """Return the 4x4 transform that turns by `angle` (radians, about y) and moves to (x, y, z)."""
    cos, sin = np.cos(angle), np.sin(angle)
    matrix = np.eye(4)
    matrix[:3, :3] = [[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]]
    matrix[:3, 3] = (x, y, z)
    return matrix
