"""Rooms of boxes with random contents, paints and light: labelled pictures beside the photos.

Rendered residences share one way of furnishing and one renderer. These rooms share nothing but
that floors, walls and ceilings are where they are, so a network that sees both has less to
learn by heart.
"""

from __future__ import annotations

import logging

import cv2
import numpy as np

from plan2scene.photos.masks import CEILING, FLOOR, WALL
from plan2scene.seeds import generator
from plan2scene.synthetic.materials import random_material
from plan2scene.training.segmentation_data import LabelledPhoto
from plan2scene.training.segmentation_furniture import Paints, furnish, hang_on_walls
from plan2scene.training.segmentation_raycast import (
    Array,
    Body,
    Eye,
    Lamp,
    Paint,
    cast,
    plain,
    shade,
    surfels,
    tiled,
)

_log = logging.getLogger("plan2scene")
#: Size (height, width) of the pictures, pixels.
SIZE = (240, 320)
#: Tiles of each substance that paints are drawn from.
TILES = 40


def random_scenes(count: int, *, seed: int) -> list[LabelledPhoto]:
    """Return `count` labelled pictures of random rooms; each depends on (seed, index) alone."""
    return [photo for photo, _ in random_scenes_and_eyes(count, seed=seed)]


def random_scenes_and_eyes(count: int, *, seed: int) -> list[tuple[LabelledPhoto, Eye]]:
    """Return labelled pictures of random rooms, each with its camera (see `scene_camera`)."""
    if count == 0:
        return []
    paints = _paints(seed)
    found = []
    for index in range(count):
        found.append(random_scene_and_eye(paints, index, seed=seed))
        if (index + 1) % 200 == 0:
            _log.info("%d rooms of boxes drawn", index + 1)
    return found


def _paints(seed: int) -> Paints:
    """Return the tiles that all rooms draw from."""
    tiles: dict[str, list[Paint]] = {}
    for substance, gloss in (("wood", 0.15), ("plaster", 0.0), ("carpet", 0.0), ("tile", 0.3)):
        rng = generator(seed, "scene paints", substance)
        tiles[substance] = []
        for _ in range(TILES):
            material = random_material(substance, int(rng.integers(2**62)), size_px=128)
            tiles[substance].append(
                tiled(material.albedo, material.size_m, gloss * float(rng.random()))
            )
    return Paints(tiles)


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
    half = np.array([rng.uniform(1.1, 3.5), rng.uniform(1.12, 1.6), rng.uniform(1.1, 4.0)])
    room = _room(half, paints, rng)
    bodies = [room, *_wall_blocks(room, rng)]
    things, lamps = hang_on_walls(half, paints, rng)
    eye = _eye(half, rng)
    bodies += things + [
        body for body in furnish(half, paints, rng) if not _too_near(body, eye.position)
    ]
    rays = eye.rays()
    seen = surfels(bodies, eye, rays, cast(bodies, eye, rays))
    ambient = np.exp(rng.normal(-1.2, 0.4) + rng.normal(0, 0.08, 3))
    lamps += _ceiling_lamps(half, rng)
    picture = shade(bodies, seen, eye, lamps, ambient, rng)
    labels = seen.label.reshape(eye.size)
    return LabelledPhoto(f"room_{index}", _developed(picture, rng), labels), eye


def _room(half: Array, paints: Paints, rng: np.random.Generator) -> Body:
    """Return the hollow box of the room: floor at y 0, walls, ceiling."""
    wall = paints.wall(rng)
    accent = paints.wall(rng) if rng.random() < 0.2 else wall
    ceiling = (
        plain(rng.uniform(0.55, 0.95) * np.exp(rng.normal(0, 0.03, 3)))
        if rng.random() < 0.85
        else paints.wall(rng)
    )
    sides = [wall, wall, paints.floor(rng), ceiling, wall, wall]
    sides[int(rng.choice([0, 1, 4, 5]))] = accent
    return Body(
        centre=np.array([0.0, half[1], 0.0]),
        half=half,
        yaw=0.0,
        labels=(WALL, WALL, FLOOR, CEILING, WALL, WALL),
        paints=tuple(sides),
        hollow=True,
    )


def _wall_blocks(room: Body, rng: np.random.Generator) -> list[Body]:
    """Return chimney breasts, columns and corners of L-shaped rooms: wall from floor to ceiling."""
    blocks = []
    for _ in range(int(rng.choice([0, 1, 2], p=[0.5, 0.35, 0.15]))):
        half = np.array([rng.uniform(0.15, 1.0), room.half[1], rng.uniform(0.12, 1.0)])
        sign = rng.choice([-1, 1], 2)
        place = np.array([sign[0], 0, sign[1]]) * room.half
        free = int(rng.choice([0, 2, 1]))  # slide along x, along z, or stay in the corner
        if free != 1:
            place[free] = rng.uniform(-1, 1) * room.half[free]
        paint = room.paints[0] if rng.random() < 0.8 else room.paints[4]
        blocks.append(
            Body(np.array([place[0], room.half[1], place[2]]), half, 0.0, (WALL,), (paint,))
        )
    return blocks


def _eye(half: Array, rng: np.random.Generator) -> Eye:
    """Return a camera near a wall or corner that looks into the room."""
    position = np.array(
        [
            rng.uniform(0.2, 0.92) * rng.choice([-1, 1]) * half[0],
            rng.uniform(0.9, 1.8),
            rng.uniform(0.2, 0.92) * rng.choice([-1, 1]) * half[2],
        ]
    )
    position[[0, 2]] = np.clip(position[[0, 2]], 0.25 - half[[0, 2]], half[[0, 2]] - 0.25)
    target = rng.uniform(-0.7, 0.7, 2) * half[[0, 2]]
    heading = np.arctan2(*(target - position[[0, 2]])) + rng.normal(0, 0.25)
    pitch, roll = np.deg2rad(rng.normal(-7, 9)), np.deg2rad(rng.normal(0, 1.5))
    forward = np.array(
        [np.sin(heading) * np.cos(pitch), np.sin(pitch), np.cos(heading) * np.cos(pitch)]
    )
    right = np.cross(forward, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    turned = np.stack(
        [
            np.cos(roll) * right + np.sin(roll) * down,
            np.cos(roll) * down - np.sin(roll) * right,
            forward,
        ]
    )
    fov = np.deg2rad(rng.uniform(45, 95))
    return Eye(position, turned, SIZE[1] / 2 / np.tan(fov / 2), SIZE)


def _too_near(body: Body, position: Array) -> bool:
    """Return whether a thing would fill the view: the camera is in it or almost."""
    reach = np.hypot(body.half[0], body.half[2]) + 0.35
    apart = np.hypot(*(body.centre - position)[[0, 2]])
    return bool(apart < reach and body.centre[1] + body.half[1] > 0.6)


def _ceiling_lamps(half: Array, rng: np.random.Generator) -> list[Lamp]:
    """Return up to three lamps below the ceiling, and sometimes a flash."""
    lamps = []
    for _ in range(int(rng.integers(1, 4))):
        place = rng.uniform(-0.8, 0.8, 3) * half
        place[1] = 2 * half[1] - rng.uniform(0.08, 0.7)
        colour = np.exp(rng.normal(0.3, 0.6)) * np.array([1.0, 0.9, 0.75]) ** rng.uniform(0, 1.5)
        lamps.append(Lamp(place, colour, rng.uniform(0.05, 0.4)))
    return lamps


def _developed(picture: Array, rng: np.random.Generator) -> Array:
    """Return a linear picture exposed, tone mapped and encoded: (h, w, 3) uint8 sRGB."""
    level = np.quantile(picture.mean(axis=2), 0.6)
    x = picture * (rng.uniform(0.25, 0.65) / max(float(level), 1e-4))
    if rng.random() < 0.6:
        x = x / (1 + 0.35 * x) * 1.2
    bloom = cv2.GaussianBlur(np.clip(x - 1, 0, 4), (0, 0), 6)
    x = np.clip(x + 0.3 * bloom, 0, 1) ** np.float32(1 / 2.2)
    return (x * 255).astype(np.uint8)
