"""Errors of rectified planes and their scale against the truth of a synthetic photo."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from plan2scene.camera import Camera
from plan2scene.photos.planes.planes import Plane
from plan2scene.photos.planes.rectification import plane_axes
from plan2scene.photos.planes.walls import PLANES

#: Half the side of a checker square in metres, and the number of squares on a plane.
HALF_CHECKER_M = 0.1
CHECKERS = 9
#: Smallest plane that is measured, as a share of the photo's pixels.
MIN_SHARE = 0.01


@dataclass(frozen=True)
class PlaneError:
    """Errors of one true plane of a photo.

    `square_deg`: largest deviation from a right angle between the lines of a checker square on the
    plane after rectification; `direction_deg`: largest angle of these lines to the rectified
    image's axes (up to quarter turns); `distance`: estimated over true distance from the camera,
    minus 1.
    """

    photo: str
    surface: str
    square_deg: float
    direction_deg: float
    distance: float
    scale_source: str


def plane_errors(
    photo: str,
    truth: Mapping[str, Any],
    plane_file: Path,
    estimate: Camera,
    planes: list[Plane],
) -> Iterator[PlaneError]:
    """Yield the errors of every true plane of which an estimated plane covers a quarter or more.

    `truth` is the photo's entry of ``cameras.json``, `plane_file` its image of plane indices.
    """
    camera = Camera.from_json(truth)
    with Image.open(plane_file) as image:
        indices = np.asarray(image)
    for index, value in enumerate(truth["planes"]):
        seen = indices == index
        if seen.mean() < MIN_SHARE:
            continue
        covered = [int((plane.mask & seen).sum()) for plane in planes]
        if not covered or max(covered) < 0.25 * seen.sum():
            continue
        plane = planes[int(np.argmax(covered))]
        normal = np.array(value["normal"])
        distance = float(normal @ np.array(truth["position"]) - value["offset"])
        pixels = np.argwhere(seen & plane.mask)[:, ::-1]
        square, direction = _checkers(camera, normal, distance, estimate, plane, pixels)
        if np.isfinite(square):
            yield PlaneError(
                photo,
                str(value["surface"]),
                square,
                direction,
                -plane.offset / distance - 1,
                plane.scale_source,
            )


def _checkers(
    camera: Camera,
    normal: np.ndarray,
    distance: float,
    estimate: Camera,
    plane: Plane,
    pixels: np.ndarray,
) -> tuple[float, float]:
    """Return the largest angle errors (square, axes); NaN if the plane is seen too obliquely."""
    rays = camera.rays(pixels)
    steep = -(rays @ normal) > np.sin(np.radians(PLANES.min_grazing_deg))
    if not steep.any():
        return float("nan"), float("nan")
    reach = distance / -(rays[steep] @ normal)
    points = (rays[steep] * reach[:, None])[
        np.linspace(0, steep.sum() - 1, CHECKERS).round().astype(int)
    ]
    down = np.array([0.0, -1.0, 0.0]) if abs(normal[1]) < 0.5 else np.array([0.0, 0.0, 1.0])
    across = np.cross(normal, down)
    square, direction = [0.0], [0.0]
    for point in points:
        lines = []
        for axis in (across, down):
            ends = np.stack([point - HALF_CHECKER_M * axis, point + HALF_CHECKER_M * axis])
            seen = estimate.rays(camera.project(ends))
            onto = seen * (plane.offset / (seen @ np.array(plane.normal)))[:, None]
            line = (onto[1] - onto[0]) @ plane_axes(plane)[:2].T
            lines.append(np.degrees(np.arctan2(line[1], line[0])))
        square.append(_off_quarter(lines[1] - lines[0]))
        direction += [_off_quarter(line) for line in lines]
    return max(square), max(direction)


def _off_quarter(angle_deg: float) -> float:
    """Return the distance of an angle to the nearest multiple of 90 degrees."""
    return float(abs((angle_deg + 45.0) % 90.0 - 45.0))
