"""One lens for the photos of a shoot: what most are sure of is told to those that are not."""

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

    sure: float = 0.9  #: confidence from which on a photo's own lines tell its focal length
    #: Least number of sure photos of a lens, and most lenses of a home.
    least: int = 3
    most: int = 2
    #: Ratio of the focal lengths of one lens to their median: zoom and errors of lines.
    near: float = 1.1
    #: Share of the sure photos that the lenses must have together; else there is none.
    share: float = 0.5


LENS = LensSettings()


def lenses_of(focals: Sequence[float]) -> list[float]:
    """Return the focal lengths (in any unit) that most photos have, the most frequent first."""
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
    """Return cameras, the unsure ones with the focal length of photos by the same camera model.

    `models` gives each photo's camera model in its EXIF data, empty for none. `refit` estimates a
    photo's camera again, given a focal length as EXIF data would tell it: surer lines of the photo
    still go before it. Focal lengths are compared in longer sides of the photo, so that portraits
    count too. Where the sure photos agree on no lens, their median stands in for the configured
    field of view alone.
    """
    known = {
        name: camera.focal_px / max(camera.width, camera.height)
        for name, camera in cameras.items()
        if camera.focal_source == "exif" or camera.confidence >= LENS.sure
    }
    made = dict(cameras)
    for name in sorted(cameras.keys() - known.keys()):
        camera, side = cameras[name], max(cameras[name].width, cameras[name].height)
        others = [known[other] for other in sorted(known) if models[other] == models[name]]
        own = camera.focal_px / side
        lenses = sorted(lenses_of(others), key=lambda lens: abs(np.log(lens / own)))
        if (
            camera.focal_source == "vanishing_points"
            and camera.confidence >= CAMERA.high_confidence
        ):
            lenses = [f for f in lenses if max(f / own, own / f) <= CAMERA.exif_tolerance]
        if lenses:
            tries = [refit(name, ExifFocal(lens * side)) for lens in lenses]
            best = max(tries, key=lambda found: round(found.confidence, 2))
        elif len(others) >= LENS.least and camera.focal_source == "config":
            best = refit(name, ExifFocal(float(np.median(others)) * side, cropped=True))
        else:
            continue
        # It is the one that was told, unless surer lines of the photo went before.
        made[name] = replace(best, focal_source="shared") if best.focal_source == "exif" else best
    return made
