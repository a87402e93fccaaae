"""Candidates of a photo: its planes for rooms of each size, and the windows drawn on them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from plan2scene.camera import Camera
from plan2scene.house import Room
from plan2scene.photos.crops.filter import judge_of, with_reason
from plan2scene.photos.crops.sampling import Candidate, CropSettings, Reason, sample_candidates
from plan2scene.photos.crops.selection import WORST_RESORT
from plan2scene.photos.planes.planes import PhotoPlane, Plane, split_planes
from plan2scene.photos.planes.walls import PLANES, RoomSize


def planes_of_photo(
    labels: np.ndarray,
    camera: Camera,
    segments: np.ndarray | None,
    rooms: Sequence[Room],
    camera_height_m: float = PLANES.camera_height_m,
) -> list[PhotoPlane]:
    """Return the planes of a photo that is not located, once for each size of its rooms.

    The other parameters are those of :func:`plan2scene.photos.planes.planes.split_planes`.
    """
    by_size: dict[RoomSize, list[str]] = {}
    for room in rooms:
        by_size.setdefault(RoomSize.of(room), []).append(room.id)
    return [
        PhotoPlane(tuple(alike), plane)
        for size, alike in by_size.items()
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
    rng: Callable[[str, int], np.random.Generator],
    inner: Sequence[np.ndarray],
) -> list[Candidate]:
    """Return the windows drawn on the planes of one photo.

    `image` is (h, w, 3) uint8 sRGB; the planes are in the frame of `camera`; `rng` returns the
    random generator of a plane's surface and number; `inner` are the pixels (h, w) bool of each
    plane that lie off its border. Planes of the same surface and number (for rooms of different
    sizes) share one count of candidates, so that different crops have different names. Of rooms
    behind a door only good candidates are kept, since they are seen from afar.
    """
    candidates: list[Candidate] = []
    count: Counter[tuple[str, int]] = Counter()
    for item, pixels in zip(planes, inner, strict=True):
        key = (item.plane.surface, item.plane.index)
        of_plane = candidates_of_plane(image, camera, item.plane, settings, rng(*key), pixels)
        candidates += [
            replace(_renumbered(candidate, count[key] + candidate.crop.index), rooms=item.rooms)
            for candidate in of_plane
            if item.own or candidate.verdict.good
        ]
        count[key] += len(of_plane)
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
    """Return the windows drawn on a plane; near its border only if no inner window is good."""
    if not settings.filter:
        return sample_candidates(image, camera, plane, rng, settings)
    inside = replace(plane, mask=inner)
    judge = judge_of(plane.surface, inside=True)
    candidates = sample_candidates(image, camera, inside, rng, settings, judge)
    if not any(candidate.verdict.good for candidate in candidates):
        few = replace(settings, per_mask=min(WORST_RESORT, settings.per_mask))
        judge = judge_of(plane.surface, inside=False)
        for candidate in sample_candidates(image, camera, plane, rng, few, judge):
            candidates.append(_renumbered(candidate, len(candidates)))
    if plane.scale_source == "prior":  # holds for every window of the plane
        candidates = [with_reason(candidate, Reason.UNKNOWN_DISTANCE) for candidate in candidates]
    return candidates
