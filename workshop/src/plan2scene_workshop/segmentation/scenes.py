"""Rooms with random contents, paints and light: labelled pictures beside the photos.

Rendered residences share one way of furnishing and one renderer. These rooms share nothing but
that floors, walls and ceilings are where they are, so a network that sees both has less to
learn by heart.
"""

from __future__ import annotations

import logging
from dataclasses import replace
from pathlib import Path

import numpy as np

from plan2scene.photos.labels.palette import OTHER
from plan2scene.seeds import generator
from plan2scene_workshop.segmentation.bodies import (
    Array,
    Body,
    Eye,
    Lamp,
)
from plan2scene_workshop.segmentation.data import LabelledPhoto
from plan2scene_workshop.segmentation.furniture import furnish
from plan2scene_workshop.segmentation.paints import Paints, random_paints
from plan2scene_workshop.segmentation.raycast import (
    cast,
    surfels,
)
from plan2scene_workshop.segmentation.rooms import (
    above,
    polished,
    random_half,
    shell,
    wall_blocks,
    wall_trim,
)
from plan2scene_workshop.segmentation.shading import Sun, shade, soft_edges
from plan2scene_workshop.segmentation.views import developed, random_eye
from plan2scene_workshop.segmentation.wallthings import hang_on_walls

_log = logging.getLogger("plan2scene")


def random_scenes(
    count: int, *, seed: int, textures: str | Path | None = None
) -> list[LabelledPhoto]:
    """Return `count` labelled pictures of random rooms (see `random_scenes_and_eyes`)."""
    return [photo for photo, _ in random_scenes_and_eyes(count, seed=seed, textures=textures)]


def random_scenes_and_eyes(
    count: int, *, seed: int, textures: str | Path | None = None
) -> list[tuple[LabelledPhoto, Eye]]:
    """Return labelled pictures of random rooms, each with its camera (see `scene_camera`).

    Parameters
    ----------
    count : int
        The first k pictures are the same for every count of k or more.
    seed : int
        With the same textures, each picture depends on (seed, index) alone.
    textures : folder, optional
        Real tiles that are mixed with procedural ones (see `random_paints`).
    """
    if count == 0:
        return []
    paints = random_paints(seed, textures)
    found = []
    for index in range(count):
        found.append(random_scene_and_eye(paints, index, seed=seed))
        if (index + 1) % 200 == 0:
            _log.info("%d rooms drawn", index + 1)
    return found


def random_scene(paints: Paints, index: int, *, seed: int) -> LabelledPhoto:
    """Return the labelled picture of one random room."""
    return random_scene_and_eye(paints, index, seed=seed)[0]


def scene_camera(eye: Eye) -> dict[str, object]:
    """Return a camera as an entry of the truth file ``cameras.json`` (see docs/conventions.md).

    Keys width, height, focal_px, cx, cy (pixels), rotation (3x3 world to camera, the world has
    y up) and position (metres).
    """
    height, width = eye.size
    return {
        "width": width,
        "height": height,
        "focal_px": float(eye.focal_px),
        "cx": (width - 1) / 2,
        "cy": (height - 1) / 2,
        "rotation": np.asarray(eye.rotation, float).tolist(),
        "position": np.asarray(eye.position, float).tolist(),
    }


def random_scene_and_eye(paints: Paints, index: int, *, seed: int) -> tuple[LabelledPhoto, Eye]:
    """Return the labelled picture of one random room and the camera that took it."""
    rng = generator(seed, "scene", index)
    half = random_half(rng)
    everything, lamps, panes = _contents(half, paints, rng)
    eye, bodies = _view(everything, rng)
    rays = eye.rays()
    hits = cast(bodies, eye, rays)
    seen = surfels(bodies, eye, rays, hits)
    ambient = np.exp(rng.normal(-1.2, 0.6) + rng.normal(0, 0.08, 3))
    lamps = sorted(lamps, key=lambda lamp: -float(lamp.colour.sum()))[:3]
    lamps += _ceiling_lamps(half, rng)
    sun = _sun(panes, ambient, rng)
    picture = shade(bodies, seen, eye, lamps, ambient, rng, sun)
    picture = soft_edges(picture, hits.body)
    labels = seen.label.reshape(eye.size)
    return LabelledPhoto(f"room_{index}", developed(picture, rng), labels), eye


def _view(everything: list[Body], rng: np.random.Generator) -> tuple[Eye, list[Body]]:
    """Return a camera that mostly sees several things, and the bodies not in its way."""
    room, wanted = everything[0], rng.uniform(0, 0.55)
    for _ in range(4):
        eye = random_eye(room.half, rng)
        bodies = [room] + [b for b in everything[1:] if not _too_near(b, room, eye.position)]
        coarse = replace(
            eye, focal_px=eye.focal_px / 10, size=(eye.size[0] // 10, eye.size[1] // 10)
        )
        rays = coarse.rays()
        labels = surfels(bodies, coarse, rays, cast(bodies, coarse, rays)).label
        shares = np.bincount(labels, minlength=256) / labels.size
        if (shares[OTHER] > wanted and shares.max() < 0.8) or rng.random() < 0.05:
            break
    return eye, bodies


def _contents(
    half: Array, paints: Paints, rng: np.random.Generator
) -> tuple[list[Body], list[Lamp], list[Body]]:
    """Return the room (first) and all in it, the lights of windows and panels, and the panes."""
    room = shell(half, paints, rng)
    bodies = [room, *polished(room, rng), *wall_blocks(room, rng), *wall_trim(room, paints, rng)]
    hung, lamps, panes = hang_on_walls(room, paints, rng)
    overhead, panels = above(room, paints, rng)
    return bodies + hung + overhead + furnish(half, paints, rng), lamps + panels, panes


def _too_near(body: Body, room: Body, position: Array) -> bool:
    """Return whether a thing would fill the view: the camera is in it or almost."""
    if body.hollow or body.beyond is not None:
        return False
    if max(body.half[0], body.half[2]) > 0.8 * min(room.half[0], room.half[2]):
        inside = np.abs(body.local(position)) < body.half + 0.05  # floors, slopes, trim
        return bool(inside.all())
    reach = np.abs(body.local(position))[[0, 2]] - body.half[[0, 2]]
    return bool((reach < 0.3).all() and body.centre[1] + body.half[1] > 0.6)


def _sun(panes: list[Body], ambient: Array, rng: np.random.Generator) -> Sun | None:
    """Return the sun behind one of the windows, for some rooms with windows."""
    if not panes or rng.random() < 0.45:
        return None
    pane = panes[int(rng.integers(len(panes)))]
    turn = pane.yaw + np.pi + rng.uniform(-1.0, 1.0)  # the pane's z looks into the room
    rise = rng.uniform(0.15, 1.1)
    towards = np.array([np.sin(turn) * np.cos(rise), np.sin(rise), np.cos(turn) * np.cos(rise)])
    colour = np.exp(rng.uniform(0.3, 2.3)) * ambient.mean() * np.array([1.1, 1.0, 0.85])
    return Sun(towards, colour, tuple(panes))


def _ceiling_lamps(half: Array, rng: np.random.Generator) -> list[Lamp]:
    """Return up to two lamps below the ceiling or on a wall, and sometimes a flash."""
    lamps = []
    for _ in range(int(rng.integers(0, 3))):
        place = rng.uniform(-0.9, 0.9, 3) * half
        place[1] = 2 * half[1] - rng.uniform(0.08, 1.0)
        colour = np.exp(rng.normal(0.2, 0.7)) * np.array([1.0, 0.9, 0.75]) ** rng.uniform(0, 2)
        lamps.append(Lamp(place, colour, rng.uniform(0.05, 0.4)))
    return lamps
