"""A tile made up for a surface of a substance that the house shows nowhere: a usual one.

A bathroom that no photo shows does not get the living room's planks in another colour. Its tile is
procedural, in the predicted colour, and says that it is made up.
"""

from __future__ import annotations

import numpy as np

from plan2scene.colour import as_uint8
from plan2scene.house import SurfaceKey
from plan2scene.materials import random_material
from plan2scene.seeds import derive_seed
from plan2scene.textures.exemplar.tone import enlarged
from plan2scene.textures.seams import with_calm_border
from plan2scene.textures.tiles import Tile

#: The kind of each substance (``materials.KINDS``), on floors and on what is not a floor.
FLOOR_KINDS = {"wood": "planks", "plaster": "concrete", "carpet": "cut", "tile": "grid"}
OTHER_KINDS = {**FLOOR_KINDS, "plaster": "paint"}
#: Materials of these kinds, of :data:`_SIZE_PX`, that were looked at and are quite ordinary.
_SEEDS = {"wood": (6, 9, 14), "plaster": (0, 1, 2), "carpet": (0, 1, 2), "tile": (9, 25, 33)}
_SIZE_PX = 256


def usual_tile(
    key: SurfaceKey, substance: str, tone: np.ndarray, *, house: str, seed: int, size_px: int
) -> Tile:
    """Return a made-up tile of a substance in about the colour `tone` (3,), sRGB in [0, 1].

    The pattern of all surfaces of that kind and substance in the house; `seed` is the global one.
    """
    kind = (FLOOR_KINDS if key.kind == "floor" else OTHER_KINDS)[substance]
    seeds = _SEEDS[substance]
    own = seeds[derive_seed(seed, "usual tile", house, key.kind, substance) % len(seeds)]
    red, green, blue = (int(level) for level in np.round(np.clip(tone, 0.0, 1.0) * 255))
    colour = red, green, blue
    made = random_material(substance, own, kind=kind, size_px=_SIZE_PX, colour_rgb=colour)
    image = with_calm_border(as_uint8(enlarged(made.albedo / 255.0, size_px)))
    source = f"made up: no exemplar of a {key.kind} of {substance} in the house"
    return Tile(image, made.size_m, source, tiles_by_construction=True)
