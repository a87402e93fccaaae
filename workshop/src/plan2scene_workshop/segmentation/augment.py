"""Augmentation, so that a network trained on rendered rooms works on real photos.

Rendered rooms look alike in ways that real ones do not. So this module varies widely the geometry
(crop, scale, turn, mirror, tilt), the things in the room (those of other photos, plain patches),
the materials of surfaces (:mod:`.surfaces`), light and camera (:mod:`.camera_looks`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
import torch

from plan2scene.photos.labels.palette import DOOR, IGNORE, OTHER, WINDOW
from plan2scene.photos.labels.segmentation import brightened, to_tensor
from plan2scene_workshop.segmentation.camera_looks import other_camera
from plan2scene_workshop.segmentation.data import LabelledPhoto
from plan2scene_workshop.segmentation.surfaces import faced, recolour_labels, retexture

#: Probability that the labels of a view are tinted, and that one label gets another material.
RECOLOUR, RETEXTURE = 0.35, 0.55
#: Probability that a view is tilted, gets things of another view, and gets each of two patches.
TILT, TRANSPLANT, PATCH = 0.5, 0.3, 0.2
#: Least share of a photo's area that a view shows.
LEAST_VIEW = 0.2


@dataclass(frozen=True)
class Batch:
    """Augmented views; each is one row of every tensor."""

    images: torch.Tensor  #: (n, 3, height, width) float32 sRGB in [0, 1]
    #: (n, height, width) float32 sine of each pixel's elevation; NaN where unknown.
    elevations: torch.Tensor
    labels: torch.Tensor  #: (n, height, width) int64; 255 (ignore) beyond the photo
    openings: torch.Tensor  #: (n,) bool: whether the labels include doors and windows
    taught: torch.Tensor  #: (n,) bool: whether teachers label the view
    #: (n, 4, height, width) float32 normal and depth, zero where unknown; None if no photo has any.
    geometry: torch.Tensor | None

    def to(self, device: str) -> Batch:
        """Return the batch on a device, images channels last."""
        parts = {k: None if v is None else v.to(device) for k, v in vars(self).items()}
        parts["images"] = self.images.to(device, memory_format=torch.channels_last)
        return Batch(**parts)  # type: ignore[arg-type]


@dataclass(eq=False)
class View:
    """A part of a photo at the size of the network's input."""

    image: np.ndarray  #: (h, w, 3) uint8 sRGB
    labels: np.ndarray  #: (h, w) uint8
    sines: np.ndarray  #: (h, w) float32 sine of the elevation, NaN where unknown
    geometry: np.ndarray | None  #: (h, w, 4) float32 normal and depth, as in a photo
    amodal: np.ndarray | None = None  #: (h, w) uint8 labels to learn instead of `labels`

    def mapped(self, move: np.ndarray) -> View:
        """Return the view warped by a homography (3, 3) of pixels; outside it labels are 255."""
        height, width = self.labels.shape

        def warp(values: np.ndarray, border: float, how: int = cv2.INTER_NEAREST) -> np.ndarray:
            return cv2.warpPerspective(
                values, move, (width, height), flags=how, borderValue=(border,) * 4
            )

        return View(
            warp(self.image, 0, cv2.INTER_LINEAR),
            warp(self.labels, IGNORE),
            warp(self.sines, np.nan),
            None if self.geometry is None else warp(self.geometry, 0),
            None if self.amodal is None else warp(self.amodal, IGNORE),
        )


def training_batch(
    photos: Sequence[LabelledPhoto],
    elevations: Sequence[np.ndarray],
    size: tuple[int, int],
    rng: np.random.Generator,
) -> Batch:
    """Return an augmented view of each photo.

    Parameters
    ----------
    photos : n photos
    elevations : n of (h, w) float32
        Sine of each pixel's elevation (:func:`.elevation_map`), NaN where it is not known.
    size : (height, width)
        Of the views.
    rng : numpy Generator
        All choices come from it.
    """
    views = [cut_view(*pair, size, rng) for pair in zip(photos, elevations, strict=True)]
    views = [_tilted(_other_surfaces(view, rng), rng) for view in views]
    for k, view in enumerate(views):
        if rng.random() < TRANSPLANT:
            transplant(view, views[k - 1], rng)
        for _ in range(2):
            if rng.random() < PATCH:
                patch(view, rng)
    geometry = None
    if any(photo.geometry is not None for photo in photos):
        empty = np.zeros((*size, 4), np.float32)
        found = [empty if view.geometry is None else view.geometry for view in views]
        geometry = torch.from_numpy(np.stack(found)).permute(0, 3, 1, 2).contiguous()
    return Batch(
        torch.stack([to_tensor(brightened(other_camera(view.image, rng))) for view in views]),
        torch.from_numpy(np.stack([view.sines for view in views])),
        torch.from_numpy(
            np.stack([v.labels if v.amodal is None else v.amodal for v in views]).astype(np.int64)
        ),
        torch.tensor([photo.openings for photo in photos]),
        torch.tensor([photo.taught for photo in photos]),
        geometry,
    )


def cut_view(
    photo: LabelledPhoto, sines: np.ndarray, size: tuple[int, int], rng: np.random.Generator
) -> View:
    """Return a random part of a photo and its elevations at `size` (height, width), maybe mirrored.

    Its area is between `LEAST_VIEW` and all of the photo's, so that wide photos also give narrow
    views.
    """
    height, width = photo.labels.shape
    aspect = size[1] / size[0] * np.exp(rng.uniform(-0.16, 0.16))
    area = rng.uniform(LEAST_VIEW, 1) * height * width
    tall = min(height, int(np.sqrt(area / aspect)), int(width / aspect))
    wide = min(width, int(tall * aspect))
    top, left = (int(rng.integers(n + 1)) for n in (height - tall, width - wide))
    way = -1 if rng.random() < 0.5 else 1

    def part(values: np.ndarray, how: int = cv2.INTER_NEAREST) -> np.ndarray:
        share = values.shape[0] / height, values.shape[1] / width
        rows, columns = (
            slice(int(start * part), max(int(start * part) + 1, round((start + n) * part)))
            for start, n, part in zip((top, left), (tall, wide), share, strict=True)
        )
        window = values[rows, columns]
        return np.ascontiguousarray(cv2.resize(window, size[::-1], interpolation=how)[:, ::way])

    geometry = photo.geometry
    if geometry is not None:
        geometry = part(geometry.astype(np.float32))
        geometry[..., 0] *= way  # a normal to the right becomes one to the left
    image = part(photo.image, cv2.INTER_AREA if tall > size[0] else cv2.INTER_LINEAR)
    amodal = None if photo.amodal is None else part(photo.amodal)
    return View(image, part(photo.labels), part(sines), geometry, amodal)


def _other_surfaces(view: View, rng: np.random.Generator) -> View:
    """Return a view, at random with other colours or materials of its surfaces."""
    image = view.image
    if rng.random() < RECOLOUR:
        image = recolour_labels(image, view.labels, rng)
    if rng.random() < RETEXTURE:
        image = retexture(image, faced(view.labels, view.geometry), rng)
    return replace(view, image=image)


def _tilted(view: View, rng: np.random.Generator) -> View:
    """Return a view, at random rotated by a few degrees, rescaled and in other perspective."""
    if rng.random() >= TILT:
        return view
    height, width = view.labels.shape
    corners = np.array([(0, 0), (width, 0), (width, height), (0, height)], np.float32)
    middle = corners.mean(axis=0)
    angle, scale = np.deg2rad(rng.uniform(-5, 5)), rng.uniform(0.95, 1.15)
    turn = scale * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    moved = (corners - middle) @ turn.T + middle
    moved += rng.uniform(-0.06, 0.06, (4, 2)) * (width, height)
    return view.mapped(cv2.getPerspectiveTransform(corners, moved.astype(np.float32)))


def transplant(view: View, other: View, rng: np.random.Generator) -> None:
    """Paste the things in a random window of another view (other, doors, windows) into a view."""
    things = np.isin(other.labels, (OTHER, DOOR, WINDOW))
    height, width = things.shape
    tall, wide = (int(rng.uniform(0.3, 1) * n) for n in (height, width))
    top, left = (int(rng.integers(n + 1)) for n in (height - tall, width - wide))
    window = np.zeros_like(things)
    window[top : top + tall, left : left + wide] = True
    _put(view, things & window, other)


def patch(view: View, rng: np.random.Generator) -> None:
    """Paste a box of one random colour into a view."""
    height, width = view.labels.shape
    area, aspect = rng.uniform(0.004, 0.06) * height * width, np.exp(rng.uniform(-1.2, 1.2))
    tall = max(1, min(height, int(np.sqrt(area * aspect))))
    wide = max(1, min(width, int(np.sqrt(area / aspect))))
    top, left = (int(rng.integers(n + 1)) for n in (height - tall, width - wide))
    where = np.zeros((height, width), bool)
    where[top : top + tall, left : left + wide] = True
    image = np.broadcast_to(rng.integers(0, 256, 3).astype(np.uint8), view.image.shape)
    labels = np.full_like(view.labels, OTHER)
    _put(view, where, View(image, labels, view.sines, None))


def _put(view: View, where: np.ndarray, other: View) -> None:
    """Paste pixels of another view into a view; the elevation stays (it depends on the camera)."""
    view.image, view.labels = view.image.copy(), view.labels.copy()
    view.image[where], view.labels[where] = other.image[where], other.labels[where]
    if view.amodal is not None:  # a thing hides what is behind it; a door or window does not
        opening = where & np.isin(other.labels, (DOOR, WINDOW))
        view.amodal = np.where(opening, other.labels, view.amodal)
    if view.geometry is not None:
        view.geometry = view.geometry.copy()
        view.geometry[where] = 0 if other.geometry is None else other.geometry[where]
