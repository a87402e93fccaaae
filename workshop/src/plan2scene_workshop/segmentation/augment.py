"""Augmentation: what makes a network trained on rendered rooms stand real photos.

Rendered rooms look alike in ways that real ones do not. So shape (crop, scale, turn, mirror,
tilt), what stands in the room (things of other photos, plain patches), light and camera are
varied widely by kornia, and what surfaces are made of by :mod:`.surfaces`.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import kornia.augmentation as ka
import numpy as np
import torch
from kornia.constants import DataKey, Resample, SamplePadding

from plan2scene.photos.labels.palette import CEILING, FLOOR, IGNORE, WALL
from plan2scene.photos.labels.segmentation import to_tensor
from plan2scene_workshop.segmentation.data import LabelledPhoto
from plan2scene_workshop.segmentation.surfaces import recolour_labels, retexture

#: Chance that each label of a photo is tinted, and that one has another material.
RECOLOUR, RETEXTURE = 0.35, 0.35
#: What kornia does to masks: nearest pixel, 0 beyond the photo's border.
_MASKS = {DataKey.MASK: {"resample": Resample.NEAREST, "padding_mode": SamplePadding.ZEROS}}


@lru_cache(maxsize=8)
def _shape(size: tuple[int, int]) -> ka.AugmentationSequential:
    """Return what makes views of `size` (height, width): of half a photo's side to all of it."""
    aspect = size[1] / size[0]
    return ka.AugmentationSequential(
        ka.RandomHorizontalFlip(),
        ka.RandomPerspective(0.2, p=0.3, sampling_method="area_preserving"),
        ka.RandomAffine(5.0, scale=(0.9, 1.1), padding_mode="reflection", p=0.5),
        ka.RandomResizedCrop(size, scale=(0.27, 1.0), ratio=(0.85 * aspect, 1.18 * aspect)),
        data_keys=["image", "mask"],
        extra_args=_MASKS,
    )


@lru_cache(maxsize=1)
def _look() -> ka.AugmentationSequential:
    """Return what puts things in front, then varies light, then the camera."""
    return ka.AugmentationSequential(
        ka.RandomTransplantation([FLOOR, WALL, CEILING, IGNORE], p=0.3),  # type: ignore[arg-type]
        # What is erased is labelled 0, which is OTHER.
        *(ka.RandomErasing((0.004, 0.06), value=grey, p=0.12) for grey in (0.1, 0.4, 0.85)),
        ka.RandomLinearIllumination(gain=(0.05, 0.35), p=0.3),
        ka.RandomGaussianIllumination(gain=(0.05, 0.5), sigma=(0.1, 0.8), p=0.3),
        ka.RandomPlanckianJitter(p=0.4),
        ka.RandomRGBShift(0.06, 0.06, 0.06, p=0.4),
        ka.ColorJitter(0.3, 0.35, 0.6),
        ka.RandomGamma((0.75, 1.35), p=0.5),
        ka.RandomGrayscale(p=0.06),
        ka.RandomGaussianBlur((7, 7), (0.4, 1.6), p=0.25),
        ka.RandomMotionBlur((3, 7), 90.0, 1.0, p=0.08),
        ka.RandomSharpness(1.2, p=0.1),
        ka.RandomGaussianNoise(std=0.02, p=0.5),
        data_keys=["image", "mask"],
    )


def training_batch(
    photos: Sequence[LabelledPhoto],
    elevations: Sequence[np.ndarray],
    size: tuple[int, int],
    rng: np.random.Generator,
    device: str = "cpu",
) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Return an augmented view of each photo.

    Parameters
    ----------
    photos : n photos of one size
    elevations : n of (h, w) float32
        Sine of each pixel's elevation (:func:`.elevation_map`), NaN where it is not known.
    size : (height, width)
        Of the views.
    rng : numpy Generator
        All choices come from it.
    device : str
        Of the result, and what kornia computes on.

    Returns
    -------
    images : (n, 3, height, width) float32 sRGB in [0, 1]
    elevations : (n, height, width) float32
        NaN where unknown, also where the view reaches beyond the photo.
    labels : (n, height, width) int64
        255 (ignore) where the view reaches beyond the photo.
    """
    images = torch.stack([to_tensor(_other_surfaces(photo, rng)) for photo in photos])
    labels = torch.from_numpy(np.stack([photo.labels for photo in photos])).float()
    sines = torch.from_numpy(np.stack(elevations))
    # Kornia fills with 0: labels are moved up by one and sines by two, so that 0 is free.
    masks = torch.stack([(labels + 1) % 256, torch.nan_to_num(sines + 2, nan=0.0)], dim=1)
    images, masks = images.to(device), masks.to(device)
    with torch.random.fork_rng(), torch.autocast(images.device.type, enabled=False):
        torch.manual_seed(int(rng.integers(2**62)))
        images, masks = _shape(size)(images, masks)
        labels = torch.where(masks[:, 0] == 0, IGNORE, masks[:, 0] - 1)
        sines = torch.where(masks[:, 1] == 0, torch.nan, masks[:, 1] - 2)
        images, labels = _look()(images, labels)
    return images.clamp(0, 1), sines, labels.reshape(sines.shape).long()


def _other_surfaces(photo: LabelledPhoto, rng: np.random.Generator) -> np.ndarray:
    """Return the photo (h, w, 3) uint8, at times with its surfaces of other looks."""
    image = photo.image
    if rng.random() < RECOLOUR:
        image = recolour_labels(image, photo.labels, rng)
    if rng.random() < RETEXTURE:
        image = retexture(image, photo.labels, rng)
    return image
