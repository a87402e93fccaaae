"""Rooms unlike those of listings: random paints, patterned textiles, clutter, odd cameras.

A network that learns to label photos only from tidy homes takes a patterned bed cover for floor
and a built-in wardrobe for wall. Therefore a share of the rooms is randomised (domain
randomisation, Tobin et al. 2017). Nothing here changes a room that is not randomised.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from plan2scene.house import SUBSTANCES, House, SurfaceKey
from plan2scene.materials import Material, random_material
from plan2scene.seeds import derive_seed, generator
from plan2scene_workshop.rendering.geometry import box, lathe, placement, superquadric
from plan2scene_workshop.rendering.palette import FABRICS, Palette, linear, pattern, pick
from plan2scene_workshop.rendering.pieces import Look, Maker, Piece, cabinet, cushion, soft
from plan2scene_workshop.rendering.tracer import Finish
from plan2scene_workshop.rendering.views import View

#: Probabilities of the materials of randomised surfaces: "paint" of any colour, "pattern", or a
#: substance.
_SURFACES: Mapping[str, Mapping[str, float]] = {
    "floor": {"wood": 0.3, "carpet": 0.4, "tile": 0.2, "plaster": 0.1},
    "wall": {"paint": 0.7, "pattern": 0.12, "tile": 0.08, "plaster": 0.06, "wood": 0.04},
    "ceiling": {"paint": 0.85, "plaster": 0.05, "wood": 0.05, "tile": 0.05},
}


def draw_random_rooms(house: House, share: float, seed: int) -> frozenset[str]:
    """Return the ids of the rooms to randomise: each with probability `share`."""
    rng = generator(seed, "random rooms", house.id)
    return frozenset(room.id for room in house.rooms if rng.random() < share)


def randomise_materials(
    materials: Mapping[SurfaceKey, Material], rooms: Collection[str], seed: int
) -> dict[SurfaceKey, Material]:
    """Return the materials of a house, with new random materials in `rooms`."""
    return {
        key: random_surface(key, derive_seed(seed, *key)) if key.room_id in rooms else material
        for key, material in materials.items()
    }


def random_surface(key: SurfaceKey, seed: int) -> Material:
    """Return a random material for a surface; paints and most carpets have any colour."""
    rng = generator(seed)
    shares = _SURFACES[key.surface]
    what = str(rng.choice(list(shares), p=list(shares.values())))
    value = rng.uniform(0.35, 1.0) if key.surface == "ceiling" else rng.uniform(0.25, 1.0)
    strong = rng.random() < 0.4
    red, green, blue = (
        round(255 * c ** (1 / 2.2))
        for c in linear(rng.random(), rng.uniform(0.3, 0.9) if strong else 0.1, value)
    )
    if what in SUBSTANCES:
        own = what == "carpet" and rng.random() < 0.7
        return random_material(what, seed, colour_rgb=(red, green, blue) if own else None)
    paint = random_material("plaster", seed, kind="paint", colour_rgb=(red, green, blue))
    if what == "pattern":
        size = float(rng.uniform(0.2, 1.5))
        return replace(paint, kind="wallpaper", albedo=pattern(rng, 256), size_m=size)
    return paint


def randomised_finishes(rng: np.random.Generator) -> dict[str, Finish]:
    """Return patterned finishes that replace a house's fabrics (bedding, sofas, curtains, rugs)."""
    return {
        name: Finish(pattern(rng, 96), float(np.exp(rng.uniform(-1.8, 0.5))), 1.0)
        for name in FABRICS
    }


def randomise_view(view: View, rng: np.random.Generator) -> View:
    """Return a view with random height, tilt and field of view, like a snapshot."""
    x, _, z = view.position
    pitch, roll = np.radians((rng.normal(-8, 9), rng.normal(0, 2.5)))
    return replace(
        view,
        position=(x, float(rng.uniform(0.9, 1.8)), z),
        pitch=float(np.clip(pitch, -0.6, 0.35)),
        roll=float(np.clip(roll, -0.12, 0.12)),
        fov=float(np.radians(rng.uniform(45, 80))),
    )


def heap(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return clothes or bedding on the floor."""
    side = rng.uniform(0.3, 0.8)
    piece = Piece(side, side, 0.3)
    for _ in range(int(rng.integers(1, 6))):
        wide, deep = rng.uniform(0.3, 0.6, 2) * side
        size = (wide, float(rng.uniform(0.05, 0.25)), deep)
        x, z = rng.uniform(-0.1, 0.1, 2) * side
        turn = placement(x, side / 2 + z, rng.uniform(0, np.pi), size[1] / 2)
        piece.add(soft(rng, palette), cushion((0, 0, 0), size, rng.uniform(0.3, 1)).moved(turn))
    return piece


def toys(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return balls, boxes and books lying about."""
    piece = Piece(rng.uniform(0.3, 1.0), rng.uniform(0.3, 0.8), 0.25)
    for _ in range(int(rng.integers(2, 9))):
        x = rng.uniform(-0.5, 0.5) * (piece.width - 0.2)
        z = rng.uniform(0.1, piece.depth - 0.1)
        half, look = rng.uniform(0.03, 0.12, 3), ("paint", pick(rng, palette.accents))
        if rng.random() < 0.4:
            piece.add(look, superquadric((x, half[0], z), (half[0],) * 3))
        else:
            thing = box((-half[0], 0, -half[1]), (half[0], half[2] * rng.uniform(0.2, 2), half[1]))
            piece.add(look, thing.moved(placement(x, z, rng.uniform(0, np.pi))))
    return piece


def basket(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return a basket, bucket or bin, sometimes full."""
    radius, tall = rng.uniform(0.12, 0.28), rng.uniform(0.2, 0.6)
    piece = Piece(2 * radius, 2 * radius, tall + 0.1)
    sides = [
        (radius * 0.8, 0),
        (radius, tall),
        (radius * 0.92, tall),
        (radius * 0.75, 0.03),
        (0, 0.03),
    ]
    piece.add(("paint", pick(rng, palette.accents)), lathe((0, 0, radius), sides, 16))
    if rng.random() < 0.5:
        piece.add(soft(rng, palette), superquadric((0, tall, radius), (radius, 0.1, radius)))
    return piece


def built_in(rng: np.random.Generator, palette: Palette) -> Piece:
    """Return a tall wardrobe with plain doors, mostly white like walls."""
    white = linear(rng.random(), rng.uniform(0, 0.08), rng.uniform(0.8, 0.97))
    look: Look = ("paint", white if rng.random() < 0.7 else pick(rng, palette.furniture))
    return cabinet(rng, palette, (rng.uniform(1.0, 3.0), 0.6, rng.uniform(2.1, 2.3)), look)


#: Makers of the additional things in randomised rooms, with the mean count of each.
ALONG_WALLS: Sequence[tuple[Maker, float]] = ((built_in, 0.5),)
STANDING_FREE: Sequence[tuple[Maker, float]] = ((heap, 1.2), (toys, 1.2), (basket, 0.7))
