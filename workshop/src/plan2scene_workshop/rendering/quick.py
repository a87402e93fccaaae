"""Renders many views of a scene quickly.

:mod:`.tracer` traces every texture and finish. Here, light is traced on one diffuse mesh with one
mean colour per face, so that every scene runs the same compiled kernels. Camera rays are cast
separately at full resolution, for faces, normals, and colours from a texture atlas with mip levels.
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plan2scene_workshop.rendering.atlas import Atlas
from plan2scene_workshop.rendering.faces import (
    EMITTERS,
    faces_of,
    radiance_of,
    split_emitters,
    uv_density,
)
from plan2scene_workshop.rendering.geometry import Geometry, JoinedGroup, Solid, merge
from plan2scene_workshop.rendering.tracer import Finish
from plan2scene_workshop.rendering.views import View

PATH_DEPTH, ROULETTE_DEPTH = 4, 3
#: The mesh in place of a missing emitter: a tiny triangle far below the scene.
_DARK = Solid(
    np.array([[0, -90, 0], [0.01, -90, 0], [0, -90, 0.01]], float),
    np.tile([0.0, -1.0, 0.0], (3, 1)),
    np.zeros((3, 2)),
    np.array([[0, 1, 2]]),
)

Image = NDArray[np.float32]


@dataclass(frozen=True)
class Hits:
    """The hit of the ray through each pixel's centre; arrays (h, w) or (h, w, 3)."""

    face: NDArray[np.int64]  #: index over all faces of the scene, -1 for none
    position: Image  #: in the world, metres; zero where nothing is hit
    normal: Image  #: in the world, towards the camera; zero where nothing is hit
    depth: Image  #: along the camera's axis, metres


class QuickTracer:
    """A scene, loaded once and rendered from any number of cameras.

    It needs a vectorised Mitsuba variant.
    """

    def __init__(self, geometry: Geometry, finishes: Mapping[str, Finish], mi: Any) -> None:
        self._mi = mi
        self._dr = importlib.import_module("drjit")
        joined = geometry.joined()
        dull = [(n, g, finishes[n]) for n, g in joined.items() if finishes[n].emission is None]
        lit = [(n, g, finishes[n]) for n, g in joined.items() if finishes[n].emission is not None]
        rows = dull + lit
        self.names = [name for name, _, _ in rows]
        self.finishes = [finish for _, _, finish in rows]
        self.faces = faces_of(rows)
        surfaces = merge([_in_tiles(group, finish) for _, group, finish in dull])
        self._load(merge([surfaces, *(_in_tiles(g, f) for _, g, f in lit)]), rows)
        shining = split_emitters([(g.solid, radiance_of(f)) for _, g, f in lit])
        scene: dict[str, Any] = {"type": "scene", "s0": self._surfaces(surfaces)}
        for k in range(EMITTERS):
            scene[f"s{k + 1}"] = self._emitter(shining[k] if k < len(shining) else None)
        self._scene = mi.load_dict(scene, optimize=False, parallel=False)
        parts = [surfaces, *(solid for solid, _ in shining)]
        self._first = self._first_faces([len(solid.faces) for solid in parts])
        self._path = mi.load_dict(
            {"type": "path", "max_depth": PATH_DEPTH, "rr_depth": ROULETTE_DEPTH}
        )

    def _load(self, whole: Solid, rows: list[tuple[str, JoinedGroup, Finish]]) -> None:
        """Store vertex and face attributes and the atlas as arrays of the renderer."""
        mi = self._mi
        self._corners = mi.UInt32(whole.faces.astype(np.uint32).ravel())
        self._normals = mi.Float(whole.normals.astype(np.float32).ravel())
        self._uv = mi.Float(whole.uv.astype(np.float32).ravel())
        self._atlas = Atlas([f.tile if f.emission is None else None for _, _, f in rows], mi)
        self._tile = mi.Int32(self._atlas.tile_of(self.faces.groups))
        self._flat = mi.Float(self.faces.colours.ravel())
        self._density = mi.Float(uv_density(whole.vertices, whole.uv, whole.faces))

    def _surfaces(self, solid: Solid) -> Any:
        mi = self._mi
        properties = mi.Properties()
        colour = {"type": "mesh_attribute", "name": "face_color"}
        properties["mesh_bsdf"] = mi.load_dict(
            {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": colour}}
        )
        return _mesh(mi, "s0", solid, properties, self.faces.colours[: len(solid.faces)])

    def _emitter(self, shining: tuple[Solid, list[float]] | None) -> Any:
        mi = self._mi
        solid, radiance = shining or (_DARK, [0.0, 0.0, 0.0])
        properties = mi.Properties()
        black = {"type": "rgb", "value": 0.0}
        properties["mesh_bsdf"] = mi.load_dict({"type": "diffuse", "reflectance": black})
        properties["mesh_emitter"] = mi.load_dict(
            {"type": "area", "radiance": {"type": "rgb", "value": radiance}}
        )
        return _mesh(mi, "e", solid, properties, None)

    def _first_faces(self, counts: list[int]) -> Any:
        """Return the index of the first face of each shape, by the renderer's shape number."""
        mi, dr = self._mi, self._dr
        first = np.cumsum([0, *counts])
        found = {}
        for k, shape in enumerate(self._scene.shapes()):
            number = int(dr.reinterpret_array(mi.UInt32, mi.ShapePtr(shape))[0])
            found[number] = int(first[min(k, len(first) - 1)])
        table = np.zeros(256, np.uint32)  # fixed size: one kernel fits all
        if max(found) >= len(table):
            raise RuntimeError("the renderer numbers shapes beyond 255")
        for number, start in found.items():
            table[number] = start
        return mi.UInt32(table)

    def _rays(self, view: View, size: tuple[int, int], samples: int = 1) -> Any:
        """Return rays through pixel centres, row by row, each `samples` times."""
        mi, dr = self._mi, self._dr
        height, width = size
        camera = view.camera(size)
        scale = dr.opaque(mi.Float, camera.focal_px)
        wide = dr.opaque(mi.UInt32, width)
        pixel = dr.arange(mi.UInt32, height * width * samples) // dr.opaque(mi.UInt32, samples)
        row = pixel // wide
        x = (mi.Float(pixel - row * wide) + dr.opaque(mi.Float, 0.5 - width / 2)) / scale
        y = (mi.Float(row) + dr.opaque(mi.Float, 0.5 - height / 2)) / scale
        axes = [
            mi.Vector3f(*[dr.opaque(mi.Float, float(c)) for c in axis]) for axis in camera.matrix
        ]
        ray = dr.normalize(x * axes[0] + y * axes[1] + axes[2])
        origin = mi.Point3f(*[dr.opaque(mi.Float, float(c)) for c in camera.position])
        return mi.Ray3f(origin, ray)

    def _cast(self, rays: Any) -> tuple[Any, Any, Any, Any]:
        """Return the hits, their validity, the faces (index over all shapes) and their corners."""
        mi, dr = self._mi, self._dr
        hit = self._scene.ray_intersect_preliminary(rays, coherent=True)
        valid = hit.is_valid()
        shape = dr.reinterpret_array(mi.UInt32, hit.shape)
        face = dr.gather(mi.UInt32, self._first, shape, valid) + hit.prim_index
        corners = [dr.gather(mi.UInt32, self._corners, 3 * face + k, valid) for k in range(3)]
        return hit, valid, face, corners

    def hits(self, view: View, size: tuple[int, int]) -> Hits:
        """Cast one ray through each pixel's centre of a (height, width) photo."""
        mi, dr = self._mi, self._dr
        rays = self._rays(view, size)
        hit, valid, face, corners = self._cast(rays)
        u, v = hit.prim_uv.x, hit.prim_uv.y
        normal = mi.Normal3f(0)
        for weight, corner in zip((1 - u - v, u, v), corners, strict=True):
            normal += weight * dr.gather(mi.Normal3f, self._normals, corner, valid)
        normal = dr.normalize(normal)
        normal = dr.select(dr.dot(normal, rays.d) > 0, -normal, normal) & valid
        position = rays(dr.select(valid, hit.t, 0))
        number = dr.select(valid, mi.Int32(face), -1)
        ahead = view.rotation()[2]
        where = np.array(position).T.reshape(*size, 3)
        facing = np.nan_to_num(np.array(normal).T.reshape(*size, 3))
        face_index = np.array(number).astype(np.int64).reshape(size)
        depth = ((where - np.array(view.position)) @ ahead).astype(np.float32)
        none = face_index < 0
        where[none], depth[none], facing[none] = 0, 0, 0
        return Hits(face_index, where, facing, depth)

    def mirrored(self, view: View, hits: Hits) -> NDArray[np.int64]:
        """Return the face (h, w) that a mirror at each hit would show; -1: none."""
        mi = self._mi
        ray = hits.position - np.array(view.position, np.float32)
        ray /= np.maximum(np.linalg.norm(ray, axis=-1, keepdims=True), 1e-9)
        ray -= 2 * (ray * hits.normal).sum(-1, keepdims=True) * hits.normal
        start = hits.position + 2e-3 * hits.normal
        points = [np.ascontiguousarray(v.reshape(-1, 3).T, np.float32) for v in (start, ray)]
        _, valid, face, _ = self._cast(mi.Ray3f(mi.Point3f(points[0]), mi.Vector3f(points[1])))
        number = np.array(self._dr.select(valid, mi.Int32(face), -1)).astype(np.int64)
        return np.where(hits.face >= 0, number.reshape(hits.face.shape), -1)

    def albedo(self, view: View, size: tuple[int, int]) -> Image:
        """Return linear albedo (h, w, 3), the mean of 2 x 2 samples per pixel; 0 on emitters."""
        mi, dr = self._mi, self._dr
        fine = (2 * size[0], 2 * size[1])
        rays = self._rays(view, fine)
        hit, valid, face, corners = self._cast(rays)
        u, v = hit.prim_uv.x, hit.prim_uv.y
        uv = mi.Point2f(0)
        for weight, corner in zip((1 - u - v, u, v), corners, strict=True):
            uv += weight * dr.gather(mi.Point2f, self._uv, corner, valid)
        spread = dr.opaque(mi.Float, 2 * np.tan(view.fov / 2) / max(fine))
        footprint = hit.t * spread * dr.gather(mi.Float, self._density, face, valid)
        tile = dr.gather(mi.Int32, self._tile, face, valid)
        flat = dr.gather(mi.Color3f, self._flat, face, valid)
        colour = self._atlas.lookup(tile, uv, footprint, valid & (tile >= 0))
        colour = dr.select(tile >= 0, colour, flat)
        colour = dr.select(valid, colour, 0)
        image = np.array(colour).T.reshape(size[0], 2, size[1], 2, 3)
        return image.mean((1, 3)).astype(np.float32)

    def light(
        self, view: View, size: tuple[int, int], samples: int, seed: int, hits: Hits
    ) -> Image:
        """Return light (h, w, 3), radiance / albedo, by `samples` paths per pixel centre.

        `hits` must be of the same view and size. The result is zero at emitters and misses.
        """
        sampler = self._mi.load_dict({"type": "independent", "sample_count": 1})
        sampler.seed(seed % 2**31, size[0] * size[1] * samples)
        rays = self._mi.RayDifferential3f(self._rays(view, size, samples))
        radiance, _, _ = self._path.sample(self._scene, sampler, rays)
        mean = np.array(radiance).T.reshape(*size, samples, 3)
        mean = np.nan_to_num(np.minimum(mean, 60.0)).mean(2)
        albedo = self.faces.colours[hits.face]
        lit = (hits.face >= 0) & (albedo.max(-1) > 0)
        return np.where(lit[..., None], mean / np.maximum(albedo, 1e-3), 0).astype(np.float32)


def _in_tiles(group: JoinedGroup, finish: Finish) -> Solid:
    """Return a group's solid with UVs in tiles of its finish."""
    return replace(group.solid, uv=group.solid.uv / finish.size_m)


def _mesh(
    mi: Any, name: str, solid: Solid, properties: Any, colours: NDArray[np.float32] | None
) -> Any:
    mesh = mi.Mesh(
        name,
        len(solid.vertices),
        len(solid.faces),
        has_vertex_normals=True,
        has_vertex_texcoords=False,
        props=properties,
    )
    if colours is not None:
        mesh.add_attribute("face_color", 3, np.ascontiguousarray(colours).ravel())
    params = mi.traverse(mesh)
    params["vertex_positions"] = solid.vertices.astype(np.float32).ravel()
    params["vertex_normals"] = solid.normals.astype(np.float32).ravel()
    params["faces"] = solid.faces.astype(np.uint32).ravel()
    params.update()
    return mesh
