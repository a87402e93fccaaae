"""The locate stage: masks and plan of one house -> cameras.json with the photos' places."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from plan2scene.camera import Camera
from plan2scene.errors import InputError
from plan2scene.house import House
from plan2scene.io import read_json, write_json
from plan2scene.photos.labels.palette import (
    PROBABILITIES,
    read_label_png,
    read_probability_png,
)
from plan2scene.photos.locate.house import Shot, locate_shots
from plan2scene.photos.locate.pose import Pose, pose_from_json, pose_to_json

_log = logging.getLogger("plan2scene")


def locate_photos(
    house: House,
    rooms_of_photo: Mapping[str, Sequence[str]],
    masks_dir: str | Path,
    output: str | Path,
    *,
    threads: int = 1,
) -> dict[str, Pose]:
    """Write a house's cameras.json and return the best pose of each photo that has one.

    Parameters
    ----------
    house : House
        The plan.
    rooms_of_photo : mapping
        Photo name to the rooms of the house that it shows: one of them it was taken in. Any
        room of the house where none is named.
    masks_dir : path
        Output of the masks stage.
    output : path
        The cameras of the masks stage with their places (``docs/conventions.md``).
    threads : int
        Photos searched at a time; the result does not depend on it.
    """
    folder = Path(masks_dir)
    file = folder / "cameras.json"
    cameras = {name: Camera.from_json(value, file=file) for name, value in read_json(file).items()}
    anywhere = [room.id for room in house.rooms]
    shots = {
        name: Shot(
            camera,
            read_label_png(folder / f"{Path(name).stem}.png", house_id=house.id, openings=True),
            tuple(dict.fromkeys(rooms_of_photo[name] or anywhere)),
            _probabilities(folder / PROBABILITIES / f"{Path(name).stem}.png", house.id),
        )
        for name, camera in sorted(cameras.items())
        if name in rooms_of_photo
    }
    poses = locate_shots(house, shots, threads)
    entries = {name: pose_to_json(cameras[name], poses.get(name)) for name in sorted(cameras)}
    write_json(output, entries)
    count = sum(pose.believed for pose in poses.values())
    _log.info("%d of %d photos located", count, len(cameras))
    return poses


def _probabilities(path: Path, house_id: str) -> np.ndarray | None:
    """Return how likely each label of a photo is, None where the masks stage left nothing."""
    return read_probability_png(path, house_id=house_id) if path.exists() else None


def read_poses(path: str | Path) -> dict[str, Pose]:
    """Return the poses of the located photos of a cameras.json, by name."""
    found = {name: pose_from_json(value, file=path) for name, value in read_json(path).items()}
    return {name: pose for name, pose in found.items() if pose is not None}


def with_found_rooms(
    house: House, rooms_of_photo: Mapping[str, Sequence[str]], cameras: str | Path | None
) -> dict[str, list[str]]:
    """Return photo -> rooms; of photos for which none is named, the room they were located in.

    `cameras` is the cameras.json of `locate_photos`, None where photos have none. Photos without
    a room are left out, those with a camera with a line that asks for it; InputError where
    no photo of the house has a room.
    """
    located = {} if cameras is None else read_poses(cameras)
    rooms = {
        photo: list(named) or ([located[photo].room_id] if photo in located else [])
        for photo, named in rooms_of_photo.items()
    }
    known = rooms if cameras is None else read_json(cameras)
    asked = sorted(photo for photo, named in rooms.items() if not named and photo in known)
    if asked:
        names = ", ".join(asked[:8]) + (f" and {len(asked) - 8} more" if len(asked) > 8 else "")
        expected = "a room_id in the photo table where a photo's place in the plan is not clear"
        fault = InputError(expected, f"none for {names}", house=house.id)
        if not any(rooms.values()):
            raise fault
        _log.warning("%s; left out", fault)
    return {photo: named for photo, named in rooms.items() if named}
