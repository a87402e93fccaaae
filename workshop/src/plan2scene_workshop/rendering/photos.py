"""Photos of a synthetic house with their truth."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from plan2scene.house import House, SurfaceKey
from plan2scene.materials import Material
from plan2scene.photos.labels.palette import without_openings
from plan2scene.seeds import derive_seed, generator
from plan2scene_workshop.rendering.camera_effects import develop, draw_style, merge_exposures
from plan2scene_workshop.rendering.decor import Decor
from plan2scene_workshop.rendering.denoise import (
    MIN_ALBEDO,
    clamp_fireflies,
    demodulate,
    filter_light,
    upsample,
)
from plan2scene_workshop.rendering.lights import look_outside
from plan2scene_workshop.rendering.scene import SKY, RoomScene, build_room_scene
from plan2scene_workshop.rendering.shell import Plane
from plan2scene_workshop.rendering.tracer import Buffers, Tracer, Truth, load_mitsuba
from plan2scene_workshop.rendering.views import View

#: Samples per pixel of the full-size guide (albedo and emitters), for edges and textures.
GUIDE_SAMPLES = 10


@dataclass(frozen=True)
class RenderedPhoto:
    """A photo and its truth."""

    view: View
    image: NDArray[np.uint8]  #: (h, w, 3) sRGB
    labels: NDArray[np.uint8]  #: (h, w): 0 other, 1 floor, 2 wall, 3 ceiling, at pixel centres
    planes: NDArray[np.uint8]  #: (h, w): index into ``camera["planes"]``, 255 none
    camera: dict[str, Any]  #: as in ``cameras.json`` of the truth (``docs/conventions.md``)


def render_house(
    house: House,
    materials: Mapping[SurfaceKey, Material],
    accents: Mapping[str, Material],
    views: Sequence[View],
    seed: int,
    *,
    height: int = 480,
    width: int = 640,
    samples_per_pixel: int = 12,
    variant: str | None = None,
    random_rooms: Collection[str] = (),
    decor: Decor | None = None,
) -> Iterator[RenderedPhoto]:
    """Yield a photo for each view, in order; consecutive views of a room share its scene.

    Parameters
    ----------
    materials : mapping
        Material of every surface of the rooms in sight.
    accents : mapping
        Material of single walls: by `room id/wall id`, or by wall id for both sides of a wall.
    samples_per_pixel : int
        Light paths per pixel of the half-size light image (see :mod:`.denoise`).
    variant : str, optional
        Mitsuba variant; the same seed and variant give the same bytes.
    random_rooms : collection of str
        Ids of rooms with random textiles and clutter (see :mod:`.randomised`).
    decor : Decor, optional
        Furniture, textiles, light and view outside; by default those of :mod:`.furniture`.

    InputError if Mitsuba is missing, or a surface in sight has no material.
    """
    mi = load_mitsuba(variant)
    for room_id, group in itertools.groupby(views, key=lambda view: view.room_id):
        shots = list(group)
        random_room = room_id in random_rooms
        scene = build_room_scene(
            house, room_id, materials, accents, shots, seed, randomised=random_room, decor=decor
        )
        tracer = Tracer(scene.geometry, scene.finishes, mi)
        for view in shots:
            yield _shoot(tracer, scene, view, (height, width), samples_per_pixel)


def _shoot(
    tracer: Tracer, scene: RoomScene, view: View, size: tuple[int, int], samples: int
) -> RenderedPhoto:
    half = ((size[0] + 1) // 2, (size[1] + 1) // 2)
    small = tracer.render(view, half, samples, derive_seed(view.seed, "light"))
    guide = tracer.guide(view, size, GUIDE_SAMPLES, derive_seed(view.seed, "guide"))
    truth = tracer.truth(view, size)
    light = light_at(small, tracer.truth(view, half), guide, truth)
    rng = generator(view.seed, "camera")
    style = draw_style(rng)
    light = merge_exposures(light, guide.albedo.max(-1) > MIN_ALBEDO, style.range_kept)
    emitted = guide.radiance * _outside(scene, truth, view)
    image = develop(light * guide.albedo + emitted, guide.albedo, style, rng)
    labels = without_openings(truth.labels)
    camera = camera_record(view, size, scene.planes)
    return RenderedPhoto(view, image, labels, truth.planes, camera)


def _outside(scene: RoomScene, hits: Truth, view: View) -> NDArray[np.float32]:
    """Return the factor (h, w, 3) of the view outside on the windows' light, 1 elsewhere."""
    windows = np.isin(hits.materials, SKY)
    near = cv2.dilate(windows.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    seen = look_outside(scene.outside, hits.position, view.position)
    return np.where(near[..., None], seen, np.float32(1))


def light_at(small: Buffers, small_hits: Truth, guide: Buffers, hits: Truth) -> NDArray[np.float32]:
    """Return denoised light (radiance / albedo) at the guide's size, from half-size `small`."""
    height, width = small.albedo.shape[:2]
    emitted = cv2.resize(guide.radiance, (width, height), interpolation=cv2.INTER_AREA)
    light, lit = demodulate(np.maximum(small.radiance - emitted, 0), small.albedo)
    light = clamp_fireflies(light, lit)
    light = filter_light(light, small_hits.normal, small_hits.position, lit.astype(np.float32))
    return upsample(light, (small_hits.normal, small_hits.position), (hits.normal, hits.position))


def camera_record(view: View, size: tuple[int, int], planes: Sequence[Plane]) -> dict[str, Any]:
    """Return the true camera in the format of ``cameras.json``."""
    camera = view.camera(size)
    return {
        "width": camera.width,
        "height": camera.height,
        "focal_px": camera.focal_px,
        "cx": camera.cx,
        "cy": camera.cy,
        "rotation": view.rotation().tolist(),
        "position": list(view.position),
        "room_id": view.room_id,
        "planes": [
            {
                "room_id": plane.key.room_id,
                "surface": plane.key.surface,
                "normal": list(plane.normal),
                "offset": plane.offset,
            }
            for plane in planes
        ],
    }
