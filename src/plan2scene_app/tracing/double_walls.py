"""Walls drawn as two lines with paper or a hatch between them, as CAD programs do: fill them."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from scipy import ndimage

from plan2scene_app.tracing.ink import ink_of, solid_walls
from plan2scene_app.tracing.looks import Look
from plan2scene_app.tracing.picture import drawn_size, first_scale, scale_by_doors
from plan2scene_app.tracing.settings import OUTSIDE, ROOM, SETTINGS, WALL


def with_filled_walls(image: np.ndarray, looks: Sequence[Look]) -> np.ndarray:
    """Return a picture (h, w, 3) uint8 with the paper between the two lines of walls as dark ink.

    A thin blank area between lines is wall if the looks see more wall there than floor and
    openings. If it turns a corner, openings count as wall. Where the looks see outside, it may be
    the rest of a wall. `image` has no text. It is returned as it is unless many of its walls are
    such areas.
    """
    if not looks:
        return image
    labels = np.full(image.shape[:2], OUTSIDE, np.uint8)
    for look in looks:
        np.maximum(labels, _in_picture(look, image.shape[:2]), out=labels)
    largest = max(looks, key=lambda look: int((look.structure == WALL).sum()))
    ppm = first_scale(largest.structure) / largest.frame.zoom
    by_size = scale_by_doors([], drawn_size(largest.structure)) / largest.frame.zoom
    thickest = SETTINGS.ending_wall * max(ppm, by_size)  # of a missed door a splinter is seen
    ink, wall = ink_of(image), labels == WALL
    blank = ink <= SETTINGS.ink
    if not wall.any() or solid_walls(ink, ppm)[wall].mean() >= SETTINGS.solid:
        return image
    areas, count = ndimage.label(blank)
    depth = cv2.distanceTransform(blank.astype(np.uint8), cv2.DIST_C, 3)
    thin = 2 * ndimage.maximum(depth, areas, np.arange(count + 1)) <= thickest
    thin[0] = False
    strips = _with_hatches(areas, thickest)
    kinds = 1 + (labels != WALL) + (labels >= ROOM)  # wall, opening, floor
    kinds[labels == OUTSIDE] = 0
    votes = np.bincount((strips * 4 + kinds).ravel(), minlength=4 * (strips.max() + 1))
    walls, openings, floors = votes.reshape(-1, 4).T[1:]
    turns = [
        box is not None and min(side.stop - side.start for side in box) > 2 * thickest
        for box in ndimage.find_objects(strips)
    ]
    is_wall = walls > openings + floors
    is_wall[1:] |= turns & (walls + openings > floors)[1:]
    filled = is_wall[strips] & thin[areas]
    if filled[wall].mean() < SETTINGS.double_walls:
        return image
    filled = cv2.dilate(filled.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    dark = np.percentile(image.reshape(-1, 3), 0.5, axis=0).astype(np.uint8)
    return np.where(filled[..., None], np.minimum(image, dark), image)


def _with_hatches(areas: np.ndarray, thickest: float) -> np.ndarray:
    """Return areas (h, w) int32, numbered from 1, with small slanted ones that touch as one."""
    sizes = np.bincount(areas.ravel())
    slanted = np.zeros(len(sizes), bool)
    for number, box in enumerate(ndimage.find_objects(areas), start=1):
        height, width = (s.stop - s.start for s in box)
        full = sizes[number] > SETTINGS.slanted_cell * height * width
        slanted[number] = max(height, width) <= 2 * thickest and not full
    cells = slanted[areas]
    hatches, _ = ndimage.label(cv2.dilate(cells.astype(np.uint8), np.ones((5, 5), np.uint8)))
    return np.where(cells, len(sizes) + hatches, areas)


def _in_picture(look: Look, shape: tuple[int, int]) -> np.ndarray:
    """Return the labels (h, w) uint8 of a look in the picture's pixels."""
    return cv2.warpAffine(
        look.structure.astype(np.uint8),
        look.frame.matrix,
        shape[::-1],
        flags=cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=OUTSIDE,
    )
