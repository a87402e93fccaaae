"""The colours that a photo shows of its planes and of the surfaces of its rooms.

Clipped pixels and the borders of masks are left out. Steep views weigh more, because they show less
glare and more of a surface.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import cv2
import numpy as np

from plan2scene.camera import Camera
from plan2scene.colour import srgb_to_linear
from plan2scene.paint.observations import PlaneColours, SurfaceColour, equal_shares
from plan2scene.photos.crops.filter import inner_mask, unclipped
from plan2scene.photos.labels.palette import CEILING, FLOOR, OTHER, WALL
from plan2scene.photos.planes.planes import PhotoPlane

MIN_PIXELS = 200  #: Planes with fewer pixels are left out
MOST_PIXELS = 20000  #: At most about this many pixels of a plane are used
#: A surface is left out if its usable pixels are less than the first share of the photo, or less
#: than the second share of the surface.
MIN_SHARE, MIN_USABLE = 0.005, 0.2
#: Side of the square that widens walls to reach window frames (so the reach is half of it), share
#: of the photo's width; least probability that a pixel of a frame belongs to a window.
FRAME_WIDTH, FRAME_LIKELY = 0.01, 0.78
_LABELS = {"floor": FLOOR, "wall": WALL, "ceiling": CEILING}


def colours_of_photo(
    image: np.ndarray,
    camera: Camera,
    planes: Sequence[PhotoPlane],
    photo: str,
    inner: Sequence[np.ndarray],
) -> list[PlaneColours]:
    """Return the colours of each plane in a photo; `image` is (h, w, 3) uint8 sRGB.

    `inner` are the pixels (h, w) bool of each plane that lie off its border.
    """
    count = len({room for item in planes if item.own for room in item.rooms})
    usable = unclipped(image)
    observed = []
    for item, mask in zip(planes, inner, strict=True):
        plane = item.plane
        rows, columns = np.nonzero(mask & usable)
        if len(rows) < MIN_PIXELS:
            continue
        share = len(rows) / plane.mask.size
        few = slice(None, None, max(1, len(rows) // MOST_PIXELS))
        rows, columns = rows[few], columns[few]
        rays = camera.rays_at(rows, columns)
        steep = (rays @ np.asarray(plane.normal)) ** 2 / (rays**2).sum(axis=1)
        # A photo that is not located may show any of its rooms, so they share the weight.
        weight = share * float(steep.mean()) / (count if item.own else 1)
        shares = equal_shares(srgb_to_linear(image[rows, columns]), steep)
        facts = photo, item.rooms, plane.surface, plane.index, item.own, item.walls
        observed.append(PlaneColours(*facts, weight, shares))
    return observed


def _joinery(
    image: np.ndarray,
    places: np.ndarray,
    photo: str,
    room_id: str,
    facts: tuple[str, int, tuple[str, ...]],
) -> list[PlaneColours]:
    """Return the colours of some pixels of a photo; none if there are too few.

    `places` (n, 2) are their rows and columns; `facts` are surface, number and walls of
    :class:`PlaneColours`.
    """
    linear = srgb_to_linear(image[tuple(places.T)])
    if len(linear) < MIN_PIXELS:
        return []
    weight = len(linear) / image[..., 0].size
    shares = equal_shares(linear, np.ones(len(linear)))
    surface, number, walls = facts
    return [PlaneColours(photo, (room_id,), surface, number, True, walls, weight, shares)]


def door_colours(
    image: np.ndarray, photo: str, room_id: str, doors: Iterable[tuple[str, np.ndarray]]
) -> list[PlaneColours]:
    """Return the colours of door leaves in a photo; `image` is (h, w, 3) uint8 sRGB.

    `doors` are opening ids and pixels (n, 2) from
    :func:`plan2scene.photos.locate.seen_doors.seen_doors`. The id, empty if unknown, takes the
    place of the wall's in `PlaneColours.walls`.
    """
    usable = unclipped(image)
    observed = []
    for index, (opening_id, pixels) in enumerate(doors):
        places = pixels[usable[tuple(pixels.T)]]
        observed += _joinery(image, places, photo, room_id, ("door", index, (opening_id,)))
    return observed


def frame_colours(
    image: np.ndarray, labels: np.ndarray, windows: np.ndarray, photo: str, room_id: str
) -> list[PlaneColours]:
    """Return the colours of window frames, the strips of windows beside walls, in a photo.

    `image` is (h, w, 3) uint8 sRGB; `labels` (h, w) uint8 as in :func:`surface_colours`; `windows`
    (h', w') float is the probability that a pixel belongs to a window, at any resolution.
    """
    height, width = labels.shape
    likely = cv2.resize(windows.astype(np.float32), (width, height)) >= FRAME_LIKELY
    wall = (labels == WALL).astype(np.uint8)
    near, border = (
        cv2.dilate(wall, np.ones((size, size), np.uint8)) > 0
        for size in (max(3, round(FRAME_WIDTH * width)), 3)
    )
    places = np.argwhere(likely & (labels == OTHER) & near & ~border & unclipped(image))
    return _joinery(image, places, photo, room_id, ("frame", 0, ()))


def surface_colours(
    image: np.ndarray, labels: np.ndarray, photo: str, rooms: Sequence[str], edges: np.ndarray
) -> list[SurfaceColour]:
    """Return the median colours of the surfaces of a photo, for each room that it shows.

    `image` (h, w, 3) uint8 sRGB, `labels` (h, w) uint8 (0 other, 1 floor, 2 wall, 3 ceiling),
    `edges` (h, w) bool from :func:`plan2scene.photos.crops.filter.strong_edges`.
    """
    usable = unclipped(image)
    observed = []
    for surface, label in _LABELS.items():
        mask = labels == label
        inner = inner_mask(mask, edges) & usable
        if inner.sum() < MIN_SHARE * labels.size or inner.sum() < MIN_USABLE * mask.sum():
            continue
        red, green, blue = (float(v) for v in np.median(srgb_to_linear(image[inner]), axis=0))
        observed += [SurfaceColour(photo, room, surface, (red, green, blue)) for room in rooms]
    return observed
