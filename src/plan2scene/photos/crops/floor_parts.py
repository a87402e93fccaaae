"""Floors of two rooms in one photo, for example through an open door: which part is the room's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import cv2
import numpy as np

from plan2scene.colour import is_wood, linear_to_srgb, rgb_to_lab
from plan2scene.paint.observations import PlaneColours, usual_colour
from plan2scene.photos.crops.filter import FILTER
from plan2scene.photos.planes.planes import PhotoPlane


def floor_parts(item: PhotoPlane, image: np.ndarray) -> list[PhotoPlane]:
    """Return a plane; a floor of several pieces is divided into those like wood and the others.

    The parts are numbered from the plane's number on. Differences of light alone do not divide a
    floor. Floors of located photos stay as they are: the plan gives each room's. `image` is
    (h, w, 3) uint8 sRGB.
    """
    plane = item.plane
    count, number = cv2.connectedComponents(plane.mask.astype(np.uint8), connectivity=4)
    if plane.surface != "floor" or item.in_plan or count <= 2:
        return [item]
    shown = [np.median(image[number == k], axis=0) for k in range(1, count)]
    wooden = np.r_[False, is_wood(rgb_to_lab(np.array(shown) / 255.0))][number]
    masks = [mask for mask in (wooden, plane.mask & ~wooden) if mask.any()]
    parts = [replace(plane, mask=mask, index=plane.index + k) for k, mask in enumerate(masks)]
    return [replace(item, plane=part) for part in parts]


def of_other_rooms(
    colours: Sequence[PlaneColours], lights: Mapping[str, np.ndarray]
) -> dict[str, list[int]]:
    """Return by photo the numbers of floor parts that belong to other rooms.

    All of this must hold: no other photo of the room shows a floor of a colour like the part's;
    most of them show wood where the part is none, or none where it is wood; another part in the
    same photo agrees with them. `lights` (3,), linear RGB by photo, are divided out.
    """
    floors = [seen for seen in colours if seen.surface == "floor" and seen.own]
    linear = [usual_colour([f.colours], [1.0]) / lights.get(f.photo, np.ones(3)) for f in floors]
    labs = rgb_to_lab(linear_to_srgb(np.minimum(np.reshape(linear, (-1, 3)), 1.0)))
    parts_of_photo: dict[str, list[int]] = {}
    agreed, against = set(), []
    for floor, lab in zip(floors, labs, strict=True):
        of_room = [f.photo != floor.photo and bool({*f.rooms} & {*floor.rooms}) for f in floors]
        other_labs = labs[np.array(of_room)]
        if not len(other_labs):
            continue
        away = np.linalg.norm((other_labs - lab) * np.array([0.5, 1.0, 1.0]), axis=1).min()
        same_wood_share = np.mean(is_wood(other_labs) == is_wood(lab))
        if away <= FILTER.group_limit and same_wood_share > 0.5:
            agreed.add((floor.photo, floor.rooms))
        elif away > FILTER.group_limit and same_wood_share <= 1.0 - FILTER.majority:
            against.append(floor)
    for floor in against:
        if (floor.photo, floor.rooms) in agreed:
            parts_of_photo.setdefault(floor.photo, []).append(floor.plane)
    return parts_of_photo
