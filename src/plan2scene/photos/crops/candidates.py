"""Candidates of a photo: its planes for rooms of each size, and the windows drawn on them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from plan2scene.camera import Camera
from plan2scene.house import House
from plan2scene.photos.crops import sampling
from plan2scene.photos.crops.filter import judge_of, with_reason
from plan2scene.photos.crops.sampling import Candidate, sample_candidates
from plan2scene.photos.crops.tables import WORST_RESORT, PhotoCandidate
from plan2scene.photos.crops.verdict import Reason
from plan2scene.photos.locate.plan_view import RoomShape
from plan2scene.photos.locate.pose import Pose
from plan2scene.photos.locate.seen_planes import seen_planes
from plan2scene.photos.planes.planes import DEFAULT_CAMERA_HEIGHT_M, Plane, split_planes
from plan2scene.photos.planes.room_size import RoomSize
from plan2scene.seeds import generator


@dataclass(frozen=True)
class CropSettings:
    """How windows are drawn: see :func:`plan2scene.photos.crops.sampling.sample_candidates`.

    `camera_height_m` is the prior of :func:`plan2scene.photos.planes.planes.split_planes`,
    `filter` switches :mod:`plan2scene.photos.crops.filter`, `colours` is one of
    :data:`plan2scene.paint.observations.COLOURS`.
    """

    sizes_m: tuple[float, ...] = sampling.WINDOW_SIZES_M
    per_mask: int = sampling.CROPS_PER_MASK
    tries: int = sampling.TRIES
    camera_height_m: float = DEFAULT_CAMERA_HEIGHT_M
    filter: bool = True
    colours: str = "photo"


@dataclass(frozen=True)
class Naming:
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


@dataclass(frozen=True)
class ShownPlane:
    """A plane of a photo and whose it is: rooms of one size, or the one that the place tells.

    `own` tells whether the photo was taken within that room, `walls` the ids of the walls on the
    plane, where the place tells them.
    """

    rooms: tuple[str, ...]
    plane: Plane
    own: bool = True
    walls: tuple[str, ...] = ()


def planes_of_photo(
    image: np.ndarray,
    labels: np.ndarray,
    camera: Camera,
    rooms_by_size: Mapping[RoomSize, tuple[str, ...]],
    settings: CropSettings,
) -> list[ShownPlane]:
    """Return the planes of a photo whose place is not known, for its rooms of each size.

    `image` (h, w, 3) uint8 sRGB, `labels` (h, w) uint8.
    """
    return [
        ShownPlane(rooms, plane)
        for size, rooms in rooms_by_size.items()
        for plane in split_planes(
            labels,
            camera,
            image=image,
            camera_height_m=settings.camera_height_m,
            room_height_m=size.height_m,
            room_extent_m=size.extent_m,
        )
    ]


def planes_of_located(
    labels: np.ndarray, pose: Pose, shapes: Mapping[str, RoomShape]
) -> list[ShownPlane]:
    """Return the planes of a located photo, each room's own; none where place and mask disagree."""
    return [
        ShownPlane((seen.room_id,), seen.plane, seen.room_id == pose.room_id, seen.walls)
        for seen in seen_planes(labels, pose, shapes)
    ]


def candidates_of_photo(
    image: np.ndarray,
    camera: Camera,
    planes: Sequence[ShownPlane],
    settings: CropSettings,
    names: Naming,
    inner: Sequence[np.ndarray],
) -> list[PhotoCandidate]:
    """Return the windows drawn on the planes of one photo.

    `image` (h, w, 3) uint8 sRGB; `camera` in whose frame the planes are; `inner` the pixels (h, w)
    bool of each plane that lie off its border. Candidates are numbered
    on from one plane to another of the same number, so that crops of different images have
    different names. Of rooms behind a door only good ones: what is seen from afar is no last
    resort.
    """
    found: list[PhotoCandidate] = []
    count: dict[tuple[str, int], int] = {}
    for shown, pixels in zip(planes, inner, strict=True):
        plane = shown.plane
        drawn = candidates_of_plane(image, camera, plane, settings, names.rng(plane), pixels)
        first = count.get((plane.surface, plane.index), 0)
        count[plane.surface, plane.index] = first + len(drawn)
        for candidate in drawn:
            if shown.own or candidate.verdict.good:
                numbered = _renumbered(candidate, first + candidate.crop.index)
                found.append(
                    PhotoCandidate(names.photo, shown.rooms, plane.surface, plane.index, numbered)
                )
    return found


def _renumbered(candidate: Candidate, index: int) -> Candidate:
    return replace(candidate, crop=replace(candidate.crop, index=index))


def candidates_of_plane(
    image: np.ndarray,
    camera: Camera,
    plane: Plane,
    settings: CropSettings,
    rng: np.random.Generator,
    inside: np.ndarray,
) -> list[Candidate]:
    """Return the windows drawn on a plane; near its border only when none `inside` is good."""
    sample = partial(
        sample_candidates, image, camera, rng=rng, sizes_m=settings.sizes_m, tries=settings.tries
    )
    if not settings.filter:
        return sample(plane, per_mask=settings.per_mask)
    inner = replace(plane, mask=inside)
    drawn = sample(inner, per_mask=settings.per_mask, judge=judge_of(plane.surface, inside=True))
    if not any(candidate.verdict.good for candidate in drawn):
        few = min(WORST_RESORT, settings.per_mask)
        for candidate in sample(plane, per_mask=few, judge=judge_of(plane.surface, inside=False)):
            drawn.append(_renumbered(candidate, len(drawn)))
    if plane.scale_source == "prior":  # no other window of the plane would be better
        drawn = [with_reason(candidate, Reason.UNKNOWN_DISTANCE) for candidate in drawn]
    return drawn
