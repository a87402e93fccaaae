"""A lens shared by the photos of a shoot: unsure photos take the focal length of the sure ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from plan2scene.camera import Camera
from plan2scene.photos.camera.exif import ExifFocal
from plan2scene.photos.camera.lines import CAMERA


@dataclass(frozen=True)
class LensSettings:
    """When photos share a lens. Set by hand on two real flats and two listings (development)."""

    sure: float = 0.9  #: least confidence at which the focal length by a photo's lines is sure
    #: Least number of sure photos for a lens, and largest number of lenses of a home.
    least: int = 3
    most: int = 2
    #: Largest ratio of the focal lengths of one lens to its central one: for zoom and for errors.
    near: float = 1.1
    #: Least share of the sure photos that belong to one of the lenses; else no lens is found.
    share: float = 0.5


LENS = LensSettings()


def lenses_of(focals: Sequence[float]) -> list[float]:
    """Return the focal lengths that most photos have, in their unit, the most frequent first."""
    left = sorted(focals)
    found: list[tuple[float, int]] = []
    while len(found) < LENS.most:
        groups = [[f for f in left if max(f / g, g / f) <= LENS.near] for g in left]
        group = max(groups, key=len, default=[])
        if len(group) < LENS.least:
            break
        found.append((float(np.median(group)), len(group)))
        left = [f for f in left if f not in group]
    enough = sum(count for _, count in found) >= LENS.share * len(focals)
    return [focal for focal, _ in found] if enough else []


def with_shared_lenses(
    cameras: Mapping[str, Camera],
    models: Mapping[str, str],
    refit: Callable[[str, ExifFocal], Camera],
) -> dict[str, Camera]:
    """Return cameras; the unsure ones get the focal length of sure photos by the same camera model.

    `models` gives each photo's camera model from its EXIF data, empty if unknown. `refit` estimates
    a photo's camera again with a given focal length, which it treats like EXIF data: confident
    lines of the photo can still replace it. Focal lengths are divided by the photo's longer side,
    so that portrait photos can be compared. Where the sure photos agree on no lens, their median
    replaces only the configured field of view.
    """
    sure_focals = {
        name: camera.focal_px / max(camera.width, camera.height)
        for name, camera in cameras.items()
        if camera.focal_source == "exif" or camera.confidence >= LENS.sure
    }
    shared_cameras = dict(cameras)
    for name in sorted(cameras.keys() - sure_focals.keys()):
        camera, side = cameras[name], max(cameras[name].width, cameras[name].height)
        model_focals = [
            sure_focals[other] for other in sorted(sure_focals) if models[other] == models[name]
        ]
        own_focal = camera.focal_px / side
        lenses = sorted(lenses_of(model_focals), key=lambda lens: abs(np.log(lens / own_focal)))
        if (
            camera.focal_source == "vanishing_points"
            and camera.confidence >= CAMERA.high_confidence
        ):
            lenses = [
                f for f in lenses if max(f / own_focal, own_focal / f) <= CAMERA.exif_tolerance
            ]
        if lenses:
            tries = [refit(name, ExifFocal(lens * side)) for lens in lenses]
            best = max(tries, key=lambda found: round(found.confidence, 2))
        elif len(model_focals) >= LENS.least and camera.focal_source == "config":
            best = refit(name, ExifFocal(float(np.median(model_focals)) * side, cropped=True))
        else:
            continue
        # Its focal length is the shared one, unless confident lines of the photo replaced it.
        shared_cameras[name] = (
            replace(best, focal_source="shared") if best.focal_source == "exif" else best
        )
    return shared_cameras
