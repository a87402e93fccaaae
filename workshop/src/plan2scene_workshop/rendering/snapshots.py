"""Training photos: many snapshots of a furnished room from any position, with full truth.

Views are chosen after the room is furnished, by a coarse ray cast. Then light is traced at a low
resolution, filtered, upsampled along edges, and multiplied by full-size albedo (:mod:`.quick`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from plan2scene.house import House, Room
from plan2scene.photos.labels.palette import CEILING, DOOR, FLOOR, OTHER, WALL
from plan2scene.plans.geometry import room_polygon
from plan2scene.seeds import derive_seed, generator
from plan2scene_workshop.rendering.camera_effects import (
    CameraStyle,
    develop,
    draw_style,
    merge_exposures,
)
from plan2scene_workshop.rendering.decor import Decor
from plan2scene_workshop.rendering.denoise import clamp_fireflies, fill_dark, filter_light, upsample
from plan2scene_workshop.rendering.lights import look_outside
from plan2scene_workshop.rendering.photos import camera_record
from plan2scene_workshop.rendering.quick import Hits, QuickTracer
from plan2scene_workshop.rendering.scene import SKY, build_room_scene
from plan2scene_workshop.rendering.shine import draw_gloss, flash_light, lamp_light, reflections
from plan2scene_workshop.rendering.views import View

#: Size of the light image relative to the photo, and its paths per pixel.
LIGHT_SCALE, LIGHT_SAMPLES = 0.375, 6
#: Aspect ratios (long side / short side) and their probabilities.
_ASPECTS = {4 / 3: 0.7, 3 / 2: 0.15, 16 / 9: 0.1, 1.0: 0.05}
_PORTRAIT = 0.25
#: Share of photos by a worse camera or photographer; the same for listed homes.
_WILD, _WILD_LISTED = 0.7, 0.2
#: Candidates per view, and the shorter side in pixels of the coarse cast that scores them.
_CANDIDATES, _COARSE = 6, 24
#: Largest share of a view of an emptied room that is door.
_DOOR = 0.2


@dataclass(frozen=True)
class Snapshot:
    """A photo and its truth."""

    view: View
    image: NDArray[np.uint8]  #: (h, w, 3) sRGB
    labels: NDArray[np.uint8]  #: (h, w): labels of the palette, including doors and windows
    normals: NDArray[np.uint8]  #: (h, w, 3) camera axes, (n + 1) / 2 * 255; 0 where nothing is hit
    depth: NDArray[np.uint16]  #: (h, w) along the camera's axis, mm; 0 where nothing is hit
    camera: dict[str, Any]  #: as in ``cameras.json`` of the truth; no planes
    #: (h, w): labels of what would be seen without furniture (amodal); None if not asked for.
    amodal: NDArray[np.uint8] | None = None


def shoot_room(
    house: House,
    room_id: str,
    materials: Any,
    accents: Any,
    decor: Decor,
    count: int,
    seed: int,
    *,
    long_side: int,
    mi: Any,
    listed: bool = False,
    amodal: bool = False,
) -> Iterator[Snapshot]:
    """Yield up to `count` snapshots of a room; fewer if it has too few good views.

    Those of a `listed` home are wide views from the border of a room, by better photographers.
    With `amodal` they include amodal labels.
    """
    scene = build_room_scene(
        house, room_id, decor.materials(materials), accents, (), seed, decor=decor
    )
    tracer = QuickTracer(scene.geometry, scene.finishes, mi)
    bare = None
    if amodal:
        bare = QuickTracer(scene.geometry.unfurnished(), scene.finishes, mi)
    gloss = draw_gloss(tracer.names, tracer.finishes, generator(seed, room_id, "gloss"))
    rng = generator(seed, house.id, room_id, "snapshots")
    room = house.room(room_id)
    things = decor.joinery or not decor.emptied
    views = choose_views(tracer, room, count, long_side, rng, things=things, listed=listed)
    wild = 1.0 if decor.randomised else _WILD_LISTED if listed else _WILD
    for index, (view, size) in enumerate(views):
        view = replace(view, seed=derive_seed(seed, house.id, room_id, "snapshot", index))
        shot = _shoot(tracer, scene.outside, gloss, view, size, wild=wild)
        yield replace(shot, amodal=_labels(bare, bare.hits(view, size))) if bare else shot


def choose_views(
    tracer: QuickTracer,
    room: Room,
    count: int,
    long_side: int,
    rng: np.random.Generator,
    *,
    things: bool = True,
    listed: bool = False,
) -> list[tuple[View, tuple[int, int]]]:
    """Return views with photo sizes (height, width): the best-scored of random candidates.

    With `things`, the score prefers views of furniture. `listed` is that of `shoot_room`.
    """
    inner = room_polygon(room).buffer(-0.2)
    if inner.is_empty:
        return []
    candidates = []
    for _ in range(_CANDIDATES * count):
        view, size = _candidate(room, inner, long_side, rng, listed=listed)
        score = _score(tracer, view, size, things=things)
        if score is not None:
            candidates.append((score + rng.uniform(0, 0.8), view, size))
    chosen: list[tuple[View, tuple[int, int]]] = []
    while candidates and len(chosen) < count:
        best = max(range(len(candidates)), key=lambda k: candidates[k][0])
        _, view, size = candidates.pop(best)
        chosen.append((view, size))
        candidates = [(s - _alike(view, v), v, z) for s, v, z in candidates]
    return chosen


def _alike(a: View, b: View) -> float:
    turn = abs(float(np.angle(np.exp(1j * (a.yaw - b.yaw)))))
    away = float(np.linalg.norm(np.subtract(a.position, b.position)))
    return 0.8 * float(np.exp(-turn / 0.6 - away / 1.5))


def _candidate(
    room: Room,
    inner: shapely.Polygon,
    long_side: int,
    rng: np.random.Generator,
    *,
    listed: bool,
) -> tuple[View, tuple[int, int]]:
    """Draw a camera anywhere in the room; half of them are like a hand-held depth camera's.

    Cameras of listed homes stand near the border of the room.
    """
    x0, z0, x1, z1 = inner.bounds
    while True:
        x, z = rng.uniform((x0, z0), (x1, z1))
        if inner.contains(shapely.Point(x, z)):
            break
    if listed or rng.random() < 0.5:
        x, z = _towards_rim(inner, x, z, rng)
    kind = rng.random()
    if listed:
        fov, height, pitch = rng.uniform(62, 105), rng.uniform(1.1, 1.65), rng.normal(-5, 5)
    elif kind < 0.5:
        fov, height, pitch = rng.uniform(52, 66), rng.uniform(0.9, 1.7), rng.normal(-13, 9)
    elif kind < 0.8:
        fov, height, pitch = rng.uniform(62, 92), rng.uniform(1.1, 1.75), rng.normal(-4, 6)
    else:
        fov, height, pitch = rng.uniform(50, 110), rng.uniform(0.6, 1.9), rng.uniform(-35, 25)
    roll = rng.normal(0, 2.5 if kind < 0.5 else 1.0) if rng.random() < 0.9 else rng.normal(0, 8)
    middle = inner.representative_point()
    yaw = np.arctan2(middle.x - x, middle.y - z) + rng.normal(0, 0.9)
    view = View(
        room.id,
        (float(x), float(min(height, room.height - 0.2)), float(z)),
        float(np.angle(np.exp(1j * yaw))),
        float(np.radians(np.clip(pitch, -35, 35))),
        float(np.radians(np.clip(roll, -15, 15))),
        float(np.radians(fov)),
        0,
    )
    aspect = float(rng.choice(list(_ASPECTS), p=list(_ASPECTS.values())))
    short = 2 * round(long_side / aspect / 2)
    tall = kind >= 0.5 and rng.random() < (1 if listed else 2) * _PORTRAIT
    return view, (long_side, short) if tall else (short, long_side)


def _towards_rim(
    inner: shapely.Polygon, x: float, z: float, rng: np.random.Generator
) -> tuple[float, float]:
    point = shapely.Point(x, z)
    rim = inner.boundary.interpolate(inner.boundary.project(point))
    share = rng.uniform(0.6, 1.0)
    return x + share * (rim.x - x), z + share * (rim.y - z)


def _score(tracer: QuickTracer, view: View, size: tuple[int, int], *, things: bool) -> float | None:
    """Return the score of a view by a coarse ray cast; None if it is unfit or too close."""
    scale = _COARSE / min(size)
    hits = tracer.hits(view, (round(size[0] * scale), round(size[1] * scale)))
    seen = hits.face >= 0
    if seen.mean() < 0.97 or (hits.depth[seen] < 0.35).mean() > 0.04:
        return None
    labels = tracer.faces.labels[hits.face]
    level = (labels == OTHER) & (hits.normal[..., 1] > 0.9)
    tops = float((level & (np.abs(hits.position[..., 1] - 0.8) < 0.45)).mean())
    if np.median(hits.depth[seen]) < (0.7 if tops > 0.1 else 0.9):
        return None
    share = [float((labels == label).mean()) for label in (FLOOR, WALL, CEILING, OTHER)]
    if share[3] > 0.9 or max(share[:3]) > 0.85:
        return None
    floor, wall, ceiling, other = share
    score = 0.9 * min(floor, 0.15) / 0.15 + 0.5 * min(wall, 0.25) / 0.25
    score += 0.1 * min(ceiling, 0.1) / 0.1
    if not things:
        # A pale door leaf that fills the view looks like a wall.
        return None if float((labels == DOOR).mean()) > _DOOR else score
    return score + 0.5 * min(tops, 0.25) / 0.25 + 1.8 * min(other, 0.65) / 0.65


def _shoot(
    tracer: QuickTracer,
    outside: NDArray[np.float32],
    gloss: NDArray[np.float32],
    view: View,
    size: tuple[int, int],
    *,
    wild: float,
) -> Snapshot:
    rng = generator(view.seed, "camera")
    coarse = (round(size[0] * LIGHT_SCALE), round(size[1] * LIGHT_SCALE))
    small = tracer.hits(view, coarse)
    light = tracer.light(view, coarse, LIGHT_SAMPLES, derive_seed(view.seed, "light"), small)
    lit = (small.face >= 0) & (tracer.faces.colours[small.face].max(-1) > 0)
    light = filter_light(
        clamp_fireflies(fill_dark(light, lit), lit),
        small.normal,
        small.position,
        lit.astype(np.float32),
    )
    hits = tracer.hits(view, size)
    light = upsample(light, (small.normal, small.position), (hits.normal, hits.position))
    light = light + flash_light(view, hits, light, rng) + lamp_light(tracer, hits, light, rng)
    albedo = tracer.albedo(view, size)
    style = _wild(draw_style(rng), rng) if wild >= 1.0 or rng.random() < wild else draw_style(rng)
    shine = reflections(tracer, gloss, view, small, hits, light)
    light = merge_exposures(light, albedo.max(-1) > 0.02, style.range_kept)
    emitted = _emitted(tracer, outside, view, hits)
    image = develop(light * albedo + shine + emitted, albedo, style, rng)
    return Snapshot(
        view,
        image,
        _labels(tracer, hits),
        _packed_normals(hits, view),
        np.clip(np.round(hits.depth * 1000), 0, 65535).astype(np.uint16),
        camera_record(view, size, ()),
    )


def _labels(tracer: QuickTracer, hits: Hits) -> NDArray[np.uint8]:
    return np.where(hits.face >= 0, tracer.faces.labels[hits.face], OTHER).astype(np.uint8)


def _emitted(
    tracer: QuickTracer, outside: NDArray[np.float32], view: View, hits: Hits
) -> NDArray[np.float32]:
    """Return emitted radiance (h, w, 3): that of lamps, and of the view outside in windows."""
    emitted = np.where((hits.face >= 0)[..., None], tracer.faces.emission[hits.face], 0)
    sky = [k for k, name in enumerate(tracer.names) if name in SKY]
    windows = np.isin(tracer.faces.groups[hits.face], sky) & (hits.face >= 0)
    if windows.any():
        seen = look_outside(outside, hits.position, view.position)
        emitted = np.where(windows[..., None], emitted * seen, emitted)
    return cv2.GaussianBlur(emitted.astype(np.float32), (0, 0), 0.5)


def _wild(style: CameraStyle, rng: np.random.Generator) -> CameraStyle:
    """Return the style of a worse camera or photographer."""
    balance = np.array(style.balance) * np.exp(rng.normal(0, 0.08, 3))
    red, green, blue = (float(gain) for gain in balance / balance.mean())
    return replace(
        style,
        exposure_stops=float(np.clip(rng.normal(-0.1, 0.75), -2.2, 1.6)),
        balance=(red, green, blue),
        cast_left=float(rng.uniform(0.0, 0.9)),
        shoulder=float(rng.uniform(0.5, 0.85)),
        contrast=float(rng.uniform(0.95, 2.1)),
        vignette=float(rng.uniform(0.0, 0.4)),
        blur_px=float(np.exp(rng.uniform(-1.2, 0.6))),
        noise=float(np.exp(rng.uniform(-5.5, -3.0))),
        range_kept=float(rng.uniform(0.8, 1.1)),
    )


def _packed_normals(hits: Hits, view: View) -> NDArray[np.uint8]:
    turned = hits.normal @ view.rotation().T.astype(np.float32)
    packed = np.round((turned + 1) / 2 * 255)
    return np.where((hits.face >= 0)[..., None], np.clip(packed, 1, 255), 0).astype(np.uint8)
