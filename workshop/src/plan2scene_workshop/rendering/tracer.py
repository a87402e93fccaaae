"""Renders a loaded scene with Mitsuba 3: radiance, guides and truth of one camera.

Mitsuba (the extra `workshop`) is imported only when something is rendered.
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plan2scene.errors import InputError
from plan2scene_app.pictures.path_tracing import sensor
from plan2scene_workshop.rendering.geometry import Geometry, JoinedGroup
from plan2scene_workshop.rendering.views import View

#: Variants in order of preference; the scalar one needs only Mitsuba and is about 4x slower.
VARIANTS = ("llvm_ad_rgb", "scalar_rgb")
PATH_DEPTH, ROULETTE_DEPTH = 5, 3


@dataclass(frozen=True)
class Finish:
    """The look of a mesh: a tile or one colour per face, and roughness."""

    tile: NDArray[np.uint8] | None = None  #: (h, w, 3) sRGB; None: the colour of each face
    size_m: float = 1.0  #: metres that one tile covers
    roughness: float = 0.6  #: in [0, 1]; at 1 the finish is plain diffuse
    metallic: bool = False  #: metal and mirrors
    two_sided: bool = False  #: plain diffuse on both sides, because models may have wrong normals
    #: Radiance of an emitter; only `light` (linear RGB) gives its colour. Mitsuba would sample a
    #: textured emitter by its texture, which fails with texture coordinates in metres.
    emission: float | None = None
    light: tuple[float, float, float] = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class Buffers:
    """The result of one rendering pass: (h, w, 3) linear RGB, averaged over each pixel."""

    radiance: NDArray[np.float32]
    albedo: NDArray[np.float32]


@dataclass(frozen=True)
class Truth:
    """The surface that the ray through each pixel's centre hits; all (h, w) or (h, w, 3)."""

    labels: NDArray[np.uint8]
    planes: NDArray[np.uint8]
    materials: NDArray[np.object_]  #: names, empty where nothing is hit
    position: NDArray[np.float32]  #: in the world, metres; zero where nothing is hit
    normal: NDArray[np.float32]  #: in the world; zero where nothing is hit


def load_mitsuba(variant: str | None = None) -> Any:
    """Return the mitsuba module with a variant set; InputError if none works.

    By default it is the first of :data:`VARIANTS` that works here (`llvm_ad_rgb` needs LLVM's
    shared library).
    """
    try:
        mi = importlib.import_module("mitsuba")
    except ImportError as error:
        raise InputError(
            "Mitsuba 3 (pip install 'plan2scene[workshop]')", f"no module ({error})"
        ) from error
    names = (variant,) if variant else VARIANTS
    failures = []
    for name in names:
        try:
            mi.set_variant(name)
            if name.startswith("llvm"):
                _try_llvm()
        except (ImportError, RuntimeError, AttributeError) as error:
            failures.append(f"{name}: {error}")
            continue
        return mi
    raise InputError(f"a working Mitsuba variant among {', '.join(names)}", "; ".join(failures))


def _try_llvm() -> None:
    """Raise RuntimeError when LLVM's library cannot be loaded."""
    drjit = importlib.import_module("drjit")
    value = drjit.llvm.Float(1.0) + drjit.llvm.Float([1.0, 2.0])
    drjit.eval(value)


class Tracer:
    """A scene loaded into Mitsuba, rendered from any number of cameras."""

    def __init__(self, geometry: Geometry, finishes: Mapping[str, Finish], mi: Any) -> None:
        self._mi = mi
        self._groups = list(geometry.joined().items())
        scene: dict[str, Any] = {"type": "scene"}
        for index, (name, group) in enumerate(self._groups):
            scene[f"m{index:03d}"] = _mesh(mi, f"m{index:03d}", group, finishes[name])
        self._scene = mi.load_dict(scene, optimize=False, parallel=False)
        self._ids = _shape_ids(mi, self._scene)
        path = {"type": "path", "max_depth": PATH_DEPTH, "rr_depth": ROULETTE_DEPTH}
        aovs = "al:albedo"
        self._image = mi.load_dict({"type": "aov", "aovs": aovs, "img": path})
        emitted = {"type": "path", "max_depth": 1}
        self._guide = mi.load_dict({"type": "aov", "aovs": aovs, "img": emitted})
        hits = "s:shape_index,t:prim_index,p:position,n:sh_normal"
        self._truth = mi.load_dict({"type": "aov", "aovs": hits})

    def render(self, view: View, size: tuple[int, int], samples: int, seed: int) -> Buffers:
        """Path-trace a view at `size` (height, width) with `samples` per pixel."""
        return self._buffers(self._image, view, size, samples, seed)

    def guide(self, view: View, size: tuple[int, int], samples: int, seed: int) -> Buffers:
        """Return the buffers without reflected light: `radiance` is that of visible emitters."""
        return self._buffers(self._guide, view, size, samples, seed)

    def _buffers(
        self, integrator: Any, view: View, size: tuple[int, int], samples: int, seed: int
    ) -> Buffers:
        sampler = {"type": "independent", "sample_count": samples}
        camera = sensor(self._mi, view.camera(size), sampler)
        image = self._mi.render(
            self._scene, sensor=camera, integrator=integrator, spp=samples, seed=seed % 2**31
        )
        data = np.asarray(image, dtype=np.float32)
        return Buffers(data[..., :3], data[..., 3:6])

    def truth(self, view: View, size: tuple[int, int]) -> Truth:
        """Cast one ray through each pixel's centre."""
        sampler = {"type": "stratified", "sample_count": 1, "jitter": False}
        camera = sensor(self._mi, view.camera(size), sampler)
        image = self._mi.render(self._scene, sensor=camera, integrator=self._truth, spp=1)
        data = np.asarray(image, dtype=np.float32)
        shape, face = data[..., 0].astype(np.int64), data[..., 1].astype(np.int64)
        labels, planes = (np.full(size, fill, np.uint8) for fill in (0, 255))
        materials = np.full(size, "", dtype=object)
        for value, index in self._ids.items():
            here = shape == value
            group = self._groups[index][1]
            labels[here] = group.labels[face[here]]
            planes[here] = group.planes[face[here]]
            materials[here] = self._groups[index][0]
        return Truth(labels, planes, materials, data[..., 2:5], data[..., 5:8])


def _shape_ids(mi: Any, scene: Any) -> dict[int, int]:
    """Return the index of our mesh for each value of the AOV `shape_index` (0: no hit)."""
    ids = {}
    for position, shape in enumerate(scene.shapes()):
        value = position + 1
        if not mi.variant().startswith("scalar"):
            drjit = importlib.import_module("drjit")
            value = int(drjit.reinterpret_array(mi.UInt32, mi.ShapePtr(shape))[0])
        ids[value] = int(shape.id()[1:])
    return ids


def _mesh(mi: Any, name: str, group: JoinedGroup, finish: Finish) -> Any:
    """Return a Mitsuba mesh with its BSDF and, for lamps and windows, its emitter."""
    properties = mi.Properties()
    properties["mesh_bsdf"] = mi.load_dict(_bsdf(mi, finish))
    if finish.emission is not None:
        properties["mesh_emitter"] = mi.load_dict(_emitter(finish))
    solid = group.solid
    mesh = mi.Mesh(
        name,
        len(solid.vertices),
        len(solid.faces),
        has_vertex_normals=True,
        has_vertex_texcoords=True,
        props=properties,
    )
    if finish.tile is None:
        mesh.add_attribute("face_color", 3, group.colours.astype(np.float32).ravel())
    params = mi.traverse(mesh)
    uv = solid.uv / finish.size_m
    params["vertex_positions"] = solid.vertices.astype(np.float32).ravel()
    params["vertex_normals"] = solid.normals.astype(np.float32).ravel()
    params["vertex_texcoords"] = uv.astype(np.float32).ravel()
    params["faces"] = solid.faces.astype(np.uint32).ravel()
    params.update()
    mesh.set_id(name)
    return mesh


def _texture(mi: Any, finish: Finish) -> dict[str, Any]:
    if finish.tile is None:
        return {"type": "mesh_attribute", "name": "face_color"}
    tile = np.ascontiguousarray(finish.tile)
    return {"type": "bitmap", "bitmap": mi.Bitmap(tile), "wrap_mode": "repeat"}


def _bsdf(mi: Any, finish: Finish) -> dict[str, Any]:
    if finish.emission is not None:
        return {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}}
    if finish.two_sided:
        return {
            "type": "twosided",
            "bsdf": {"type": "diffuse", "reflectance": _texture(mi, finish)},
        }
    if finish.roughness >= 1.0 and not finish.metallic:
        return {"type": "diffuse", "reflectance": _texture(mi, finish)}
    return {
        "type": "principled",
        "base_color": _texture(mi, finish),
        "roughness": finish.roughness,
        "metallic": 1.0 if finish.metallic else 0.0,
        "specular": 0.5,
    }


def _emitter(finish: Finish) -> dict[str, Any]:
    strength = float(finish.emission or 0.0)
    radiance = {"type": "rgb", "value": [strength * c for c in finish.light]}
    return {"type": "area", "radiance": radiance}
