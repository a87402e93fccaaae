"""A plan format of one square room, a texture method of greys, an export that lists rooms."""

import numpy as np

from plan2scene.house import House, Room
from plan2scene.plans.plan_file import PlanFormat
from plan2scene.textures.methods import TextureMethod
from plan2scene.textures.tiles import Tile
from plan2scene_app.exports.registry import Export


def _read(plan):
    """Read ``square SIDE``; the scale turns the side into metres."""
    side = float(plan.text.split()[1]) * plan.metres_per_pixel
    ring = ((0.0, 0.0), (side, 0.0), (side, side), (0.0, side))
    return House(plan.house_id, (Room("hall", ("Unknown",), (ring,), 2.5),), ())


def _grey(inputs):
    """Make tiles as bright as the surface's first crop, grey where it has none."""
    tiles = {}
    for surface in inputs.surfaces:
        own = [crop for crop in inputs.crops if crop.key == surface.key]
        level = own[0].image().mean() if own else 128
        size = inputs.settings.size_px
        tiles[surface.key] = Tile(np.full((size, size, 3), level, np.uint8), 1.0, "toy", True)
    return tiles


def _rooms(house, textures, folder):
    (folder / "rooms.txt").write_text("".join(f"{room.id}\n" for room in house.rooms))


SQUARE = PlanFormat(
    "square", lambda plan: plan.text.startswith("square"), _read, (".square",), needs_scale=True
)
TOY = TextureMethod("toy", "a grey as bright as its crop", "grey", _grey)
SECOND_CROP = TextureMethod("crop", "another one", "another one", _grey)
ROOMS = Export("rooms", _rooms, ("rooms.txt",), "a list of rooms", needs="toy-tools")
