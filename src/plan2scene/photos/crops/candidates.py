"""Candidates of a photo: its planes for rooms of each size, and the windows drawn on them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from plan2scene.camera import Camera
from plan2scene.house import House
from plan2scene.photos.crops.filter import judge_of, with_reason
from plan2scene.photos.crops.sampling import SAMPLING, Candidate, Reason, sample_candidates
from plan2scene.photos.crops.selection import WORST_RESORT
from plan2scene.photos.planes.planes import PhotoPlane, Plane, split_planes
from plan2scene.photos.planes.walls import PLANES, RoomSize
from plan2scene.seeds import generator


@dataclass(frozen=True)
class CropSettings:
    """How windows are drawn: see :func:`plan2scene.photos.crops.sampling.sample_candidates`.

    `camera_height_m` is the prior of :func:`plan2scene.photos.planes.planes.split_planes`,
    `filter` switches :mod:`plan2scene.photos.crops.filter`.
    """

    sizes_m: tuple[float, ...] = SAMPLING.sizes_m
    per_mask: int = SAMPLING.per_mask
    tries: int = SAMPLING.tries
    camera_height_m: float = PLANES.camera_height_m
    filter: bool = True


@dataclass(frozen=True)
class WindowSeed:
    """What the windows of a photo are drawn by."""

    seed: int
    house_id: str
    photo: str

    def rng(self, plane: Plane) -> np.random.Generator:
        """Return the generator of a plane's windows."""
        return generator(self.seed, "crops", self.house_id, self.photo, plane.surface, plane.index)


def rooms_by_size(house: House, rooms: Sequence[str]) -> dict[RoomSize, tuple[str, ...]]:
    """Return the rooms by their height and extent in the plan, in their order."""
    groups: dict[RoomSize, list[str]] = {}
    for name in dict.fromkeys(rooms):
        room = house.room(name)
        groups.setdefault(RoomSize.of(room), []).append(name)
    return {size: tuple(members) for size, members in groups.items()}


def planes_of_photo(
    labels: np.ndarray,
    camera: Camera,
    segments: np.ndarray | None,
    rooms_by_size: Mapping[RoomSize, tuple[str, ...]],
    camera_height_m: float = PLANES.camera_height_m,
) -> list[PhotoPlane]:
    """Return the planes of a photo without a known place, for its rooms of each size.

    `labels` (h, w) uint8; the others as of :func:`plan2scene.photos.planes.planes.split_planes`.
    """
    return [
        PhotoPlane(rooms, plane)
        for size, rooms in rooms_by_size.items()
        for plane in split_planes(
            labels,
            camera,
            segments=segments,
            camera_height_m=camera_height_m,
            room_height_m=size.height_m,
            room_extent_m=size.extent_m,
        )
    ]


def candidates_of_photo(
    image: np.ndarray,
    camera: Camera,
    planes: Sequence[PhotoPlane],
    settings: CropSettings,
    seed: WindowSeed,
    inner: Sequence[np.ndarray],
) -> list[Candidate]:
    """Return the windows drawn on the planes of one photo.

    `image` (h, w, 3) uint8 sRGB; `camera` in whose frame the planes are; `inner` the pixels (h, w)
    bool of each plane that lie off its border. Planes of the same number (for rooms of another
    size) share one count of candidates, so that crops of different images have different names. Of
    rooms behind a door only good candidates count: what is seen from afar is no last resort.
    """
    candidates: list[Candidate] = []
    count: dict[tuple[str, int], int] = {}
    for item, pixels in zip(planes, inner, strict=True):
        plane = item.plane
        of_plane = candidates_of_plane(image, camera, plane, settings, seed.rng(plane), pixels)
        first = count.get((plane.surface, plane.index), 0)
        count[plane.surface, plane.index] = first + len(of_plane)
        candidates += [
            replace(
                _renumbered(candidate, first + candidate.crop.index),
                photo=seed.photo,
                rooms=item.rooms,
            )
            for candidate in of_plane
            if item.own or candidate.verdict.good
        ]
    return candidates


def _renumbered(candidate: Candidate, index: int) -> Candidate:
    return replace(candidate, crop=replace(candidate.crop, index=index))


def candidates_of_plane(
    image: np.ndarray,
    camera: Camera,
    plane: Plane,
    settings: CropSettings,
    rng: np.random.Generator,
    inner: np.ndarray,
) -> list[Candidate]:
    """Return the windows drawn on a plane; near its border only when none in `inner` is good."""
    sample = partial(
        sample_candidates, image, camera, rng=rng, sizes_m=settings.sizes_m, tries=settings.tries
    )
    if not settings.filter:
        return sample(plane, per_mask=settings.per_mask)
    inside = replace(plane, mask=inner)
    judge = judge_of(plane.surface, inside=True)
    candidates = sample(inside, per_mask=settings.per_mask, judge=judge)
    if not any(candidate.verdict.good for candidate in candidates):
        few = min(WORST_RESORT, settings.per_mask)
        for candidate in sample(plane, per_mask=few, judge=judge_of(plane.surface, inside=False)):
            candidates.append(_renumbered(candidate, len(candidates)))
    if plane.scale_source == "prior":  # no other window of the plane would be better
        candidates = [with_reason(candidate, Reason.UNKNOWN_DISTANCE) for candidate in candidates]
    return candidates
