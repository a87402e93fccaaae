"""Augmentation: what makes a network trained on rendered rooms stand real photos.

Rendered rooms look alike in ways that real ones do not. So shape (crop, scale, turn, mirror,
tilt, lens), what stands in the room (things of other photos, plain patches), what surfaces look
like (each label recoloured and given other materials on its own), light and camera are all
varied widely.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np

from plan2scene.photos.labels.palette import OTHER
from plan2scene_workshop.segmentation.data import LabelledPhoto
from plan2scene_workshop.segmentation.effects import (
    camera_effects,
    recolour_labels,
    retexture,
    sun_and_shade,
)
from plan2scene_workshop.segmentation.patterns import palette, surface_tiles
from plan2scene_workshop.segmentation.warp import random_warp

__all__ = ["random_view", "recolour_labels", "training_sample", "training_sample_with_map"]

Array = np.ndarray


def training_sample(
    photos: Sequence[LabelledPhoto], index: int, size: tuple[int, int], rng: np.random.Generator
) -> tuple[Array, Array]:
    """Return an augmented view of ``photos[index]``: (h, w, 3) uint8 sRGB, (h, w) uint8 labels.

    Parameters
    ----------
    size : (height, width)
        Of the view.
    rng : numpy Generator
        All choices come from it.
    """
    warp = random_warp(photos[index].labels.shape, size, rng)
    image, labels = warp.image(photos[index].image), warp.labels(photos[index].labels)
    return _changed(photos, image, labels, rng)


def training_sample_with_map(
    photos: Sequence[LabelledPhoto],
    maps: Mapping[int, Array],
    index: int,
    size: tuple[int, int],
    rng: np.random.Generator,
) -> tuple[Array, Array, Array]:
    """Return `training_sample`'s image and labels, and ``maps[index]`` in the same view.

    Parameters
    ----------
    maps : mapping of int to (h, w) or (h, w, c) float32
        Values per pixel of photo `index`, of the photo's size.

    Returns
    -------
    image, labels, map
        The map is float32 and NaN where the view reaches beyond the photo.
    """
    warp = random_warp(photos[index].labels.shape, size, rng)
    image, labels = warp.image(photos[index].image), warp.labels(photos[index].labels)
    return *_changed(photos, image, labels, rng), warp.values(maps[index])


def _changed(
    photos: Sequence[LabelledPhoto], image: Array, labels: Array, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Return a view after all that changes its look or puts something in front."""
    if rng.random() < 0.35:
        image = recolour_labels(image, labels, rng)
    if rng.random() < 0.35:
        image = retexture(image, labels, rng)
    if rng.random() < 0.35:
        donor = random_view(photos[int(rng.integers(len(photos)))], labels.shape, rng)
        image, labels = paste_thing(image, labels, *donor, rng)
    if rng.random() < 0.25:
        image, labels = paste_patches(image, labels, rng)
    if rng.random() < 0.25:
        image = sun_and_shade(image, labels, rng)
    return camera_effects(image, rng), labels


def random_view(
    photo: LabelledPhoto, size: tuple[int, int], rng: np.random.Generator
) -> tuple[Array, Array]:
    """Return a random view (see `random_warp`); labels outside the photo are ignore."""
    warp = random_warp(photo.labels.shape, size, rng)
    return warp.image(photo.image), warp.labels(photo.labels)


def paste_thing(
    image: Array, labels: Array, donor: Array, donor_labels: Array, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Return the photo with one connected thing of another photo in front, labelled other."""
    count, parts, stats, _ = cv2.connectedComponentsWithStats((donor_labels == OTHER).astype("u1"))
    area = stats[1:, cv2.CC_STAT_AREA] / labels.size
    fitting = np.flatnonzero((area > 0.004) & (area < 0.35)) + 1
    if count < 2 or not len(fitting):
        return image, labels
    mask = parts == rng.choice(fitting)
    shift = np.array([[1, 0, rng.normal(0, 0.2) * mask.shape[1]], [0, 1, 0]], np.float32)
    size = (mask.shape[1], mask.shape[0])
    mask = cv2.warpAffine(mask.astype("u1"), shift, size, flags=cv2.INTER_NEAREST) > 0
    moved = cv2.warpAffine(donor, shift, size)
    gain = np.exp(rng.normal(0, 0.2, 3))
    image, labels = image.copy(), labels.copy()
    image[mask] = np.clip(moved[mask] * gain, 0, 255)
    labels[mask] = OTHER
    return image, labels


def paste_patches(image: Array, labels: Array, rng: np.random.Generator) -> tuple[Array, Array]:
    """Return the photo with up to three flat, striped or textured shapes, labelled other."""
    image, labels = image.copy(), labels.copy()
    height, width = labels.shape
    for _ in range(int(rng.integers(1, 4))):
        mask = np.zeros_like(labels)
        centre = (int(rng.uniform(0, width)), int(rng.uniform(0, height)))
        axes = (int(width * rng.uniform(0.02, 0.16)), int(height * rng.uniform(0.03, 0.2)))
        if rng.random() < 0.3:
            cv2.ellipse(mask, centre, axes, rng.uniform(0, 180), 0, 360, 1, -1)
        else:
            turn = rng.choice([0.0, rng.normal(0, 15)])
            box = cv2.boxPoints((centre, (2 * axes[0], 2 * axes[1]), turn))
            skew = rng.normal(0, 0.12, (4, 2)) * axes
            cv2.fillConvexPoly(mask, (box + skew).astype(np.int32), 1)
        rows, columns = np.nonzero(mask)
        image[rows, columns] = np.clip(_fill(rows, columns, rng), 0, 255)
        labels[rows, columns] = OTHER
    return image, labels


def _fill(rows: Array, columns: Array, rng: np.random.Generator) -> Array:
    """Return (n, 3) colours of a patch: waves on a plain ground, or a tile."""
    light = 1 + rng.normal(0, 0.002) * (rows - rows.mean() if len(rows) else rows)
    if rng.random() < 0.5:
        wave = np.sin(columns * rng.uniform(0.02, 1.2)) * rng.uniform(0, 30)
        return np.asarray((palette(rng, 1) + wave[:, None]) * light[:, None])
    tiles = surface_tiles()
    tile = tiles[int(rng.integers(len(tiles)))]
    step = np.exp(rng.uniform(-0.5, 1.0))
    side = tile.shape[0]
    texel = tile[(rows * step).astype(int) % side, (columns * step).astype(int) % side]
    return np.asarray(texel * light[:, None])
