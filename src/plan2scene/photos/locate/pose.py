"""A photo's pose in the plan, and its entry in ``cameras.json``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from plan2scene.camera import Camera
from plan2scene.errors import InputError
from plan2scene.house import House
from plan2scene.photos.locate.plan_view import RoomShape, look
from plan2scene.stage_json import read_stage_json

#: A photo with at least this probability counts as located.
LOCATED = 0.5


@dataclass(frozen=True)
class Pose:
    """Where a photo was taken. The camera is in the plan's frame (``docs/conventions.md``)."""

    #: Room that the camera stands in.
    room_id: str
    #: x, y, z of the camera, metres.
    position: tuple[float, float, float]
    #: The photo's camera, its rotation world to camera in the plan's frame.
    camera: Camera
    #: Probability that room, heading and position are right.
    located: float

    @property
    def believed(self) -> bool:
        """Whether the photo counts as located."""
        return self.located >= LOCATED

    @property
    def eye(self) -> np.ndarray:
        """Return the position as a (3,) float64 array."""
        return np.array(self.position)


def turned(camera: Camera, turn: float) -> Camera:
    """Return a camera rotated from its Manhattan frame to the plan's: azimuths grow by `turn`."""
    sine, cosine = np.sin(turn), np.cos(turn)
    to_frame = np.array([[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]])
    return camera.with_rotation(camera.matrix @ to_frame)


def points_shown(
    points: np.ndarray, pose: Pose, shapes: Mapping[str, RoomShape], hole: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return pixels (n, 2) of points (n, 3) in an opening, and which the photo shows, (n,) bool.

    `hole` is the number of the opening in the pose's room; no wall of the room hides those shown.
    """
    camera = replace(pose.camera, position=pose.position)
    pixels = camera.project(points)
    inside = (pixels >= 0) & (pixels <= np.array([camera.width - 1, camera.height - 1]))
    eye = pose.eye[[0, 2]]
    away = points[:, [0, 2]] - eye
    azimuth = np.arctan2(away[:, 0], away[:, 1])
    sight = look(shapes, pose.room_id, np.tile(eye, (len(points), 1)), azimuth)
    return pixels, inside.all(axis=1) & (sight.hole == hole)


def pose_to_json(camera: Camera, pose: Pose | None) -> dict[str, Any]:
    """Return a photo's entry of cameras.json; `camera` is in the photo's Manhattan frame.

    If the photo is not located, room and position are null and the camera stays in that frame.
    """
    if pose is None or not pose.believed:
        located = 0.0 if pose is None else round(pose.located, 4)
        return {**camera.to_json(), "room_id": None, "position": None, "located": located}
    return {
        **pose.camera.to_json(),
        "room_id": pose.room_id,
        "position": [round(value, 4) for value in pose.position],
        "located": round(pose.located, 4),
    }


def pose_from_json(value: Any, *, file: object = "") -> Pose | None:
    """Return the pose from values of `pose_to_json`; None for a photo that is not located.

    Raises InputError if `value` is not an entry of cameras.json.
    """
    camera = Camera.from_json(value, file=file)
    if value.get("room_id") is None:
        return None
    try:
        x, y, z = (float(number) for number in value["position"])
        return Pose(str(value["room_id"]), (x, y, z), camera, float(value["located"]))
    except (KeyError, TypeError, ValueError) as error:
        expected = "a located camera (room_id, position, located)"
        raise InputError(expected, f"{type(error).__name__}: {error}", file=file) from None


def read_poses(path: str | Path, house: House | None = None) -> dict[str, Pose]:
    """Return a cameras.json's poses of located photos, by name; their rooms must be in `house`."""
    poses = {
        name: pose_from_json(value, file=path)
        for name, value in read_stage_json(path, "cameras", house=house).items()
    }
    return {name: pose for name, pose in poses.items() if pose is not None}
