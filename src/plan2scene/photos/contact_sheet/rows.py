"""One row of a contact sheet: what is known of a photo, and its panels with their captions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np

from plan2scene.camera import Camera
from plan2scene.errors import InputError
from plan2scene.io import read_json
from plan2scene.photos.contact_sheet import panels, place
from plan2scene.photos.contact_sheet.panels import fit
from plan2scene.photos.contact_sheet.windows import Window
from plan2scene.photos.labels.palette import LABELS, read_label_png
from plan2scene.photos.locate.plan_view import RoomShape
from plan2scene.photos.locate.pose import Pose
from plan2scene.photos.locate.seen_planes import seen_planes
from plan2scene.photos.photo_files import read_photo
from plan2scene.photos.planes.planes import Plane, split_planes
from plan2scene.photos.planes.room_size import RoomSize

#: Height and width of a panel, pixels.
PANEL = (225, 300)


@dataclass(frozen=True)
class SheetPhoto:
    """One row: the photo reduced to a panel, what is known of it, and why it may be missing."""

    name: str
    rooms: tuple[str, ...]
    image: np.ndarray | None
    full: np.ndarray | None
    windows: tuple[Window, ...]
    camera: Camera | None = None
    labels: np.ndarray | None = None
    note: str = ""
    #: Where it was taken, if that is known.
    pose: Pose | None = None


def sheet_photo(
    name: str,
    path: Path | None,
    rooms: tuple[str, ...],
    windows: Sequence[Window],
    masks_dir: str | Path | None,
    house_id: str,
    pose: Pose | None = None,
) -> SheetPhoto:
    """Return a photo with its mask, camera and place, or with a note why it has none."""
    empty = SheetPhoto(name, rooms, None, None, tuple(windows))
    if path is None:
        return replace(empty, note="not in the house table")
    try:
        full = read_photo(path, house_id=house_id)
    except InputError as error:
        return replace(empty, note=str(error))
    photo = replace(empty, image=fit(full, PANEL), full=full)
    if masks_dir is None:
        return replace(photo, note="crops come from a folder: no masks, no camera")
    folder = Path(masks_dir)
    camera = read_json(folder / "cameras.json").get(name)
    if camera is None:
        lines = read_json(folder / "warnings.json")
        line = next((line for line in lines if line.startswith(f"photo {name} ")), "no mask")
        return replace(photo, note=line)
    labels = read_label_png(folder / f"{Path(name).stem}.png", house_id=house_id)
    return replace(photo, labels=labels, camera=Camera.from_json(camera), pose=pose)


def row_panels(
    photo: SheetPhoto,
    room_size: RoomSize | None,
    camera_height_m: float,
    shapes: Mapping[str, RoomShape],
) -> list[tuple[np.ndarray, str]]:
    """Return the panels of a photo with their captions, as far as it got."""
    if photo.image is None or photo.full is None:
        return []
    height, width = photo.full.shape[:2]
    scale = photo.image.shape[1] / width
    found = [(panels.windows_panel(photo.image, photo.windows, scale), f"{width}x{height}")]
    if photo.camera is None or photo.labels is None:
        return found
    # Planes are looked for at three times the panel's size: enough for a picture, and quick.
    image = fit(photo.full, (3 * PANEL[0], 3 * PANEL[1])) if scale < 1 / 3 else photo.full
    size = (image.shape[0], image.shape[1])
    labels = _resized(photo.labels, size)
    seen = []
    if photo.pose is not None:
        camera = panels.scaled_camera(photo.pose.camera, size)
        seen = seen_planes(labels, replace(photo.pose, camera=camera), shapes)
    if seen:
        planes = [item.plane for item in seen]
    else:
        camera = panels.scaled_camera(photo.camera, size)
        planes = split_planes(
            labels,
            camera,
            image=image,
            camera_height_m=camera_height_m,
            room_height_m=room_size.height_m if room_size else None,
            room_extent_m=room_size.extent_m if room_size else None,
        )
    small = (photo.image.shape[0], photo.image.shape[1])
    thin = [replace(p, mask=_resized(p.mask.astype(np.uint8), small) > 0) for p in planes]
    shares = ", ".join(f"{LABELS[k]} {(labels == k).mean():.0%}" for k in (1, 2, 3))
    return [
        *found,
        (panels.mask_panel(photo.image, _resized(photo.labels, small), thin), shares),
        (fit(panels.lines_panel(image, camera), PANEL), _camera_text(photo.camera)),
        (panels.planes_panel(image, camera, planes, PANEL), _planes_text(planes)),
        *_place_panels(photo, shapes),
    ]


def _place_panels(
    photo: SheetPhoto, shapes: Mapping[str, RoomShape]
) -> list[tuple[np.ndarray, str]]:
    """Return the plan with the photo's frustum, and the photo with the plan's edges over it."""
    plan = place.plan_panel(shapes, photo.pose, PANEL)
    if photo.pose is None or photo.image is None:
        return [(plan, "not located")]
    text = f"in {photo.pose.room_id}, located {photo.pose.located:.2f}"
    return [(plan, text), (place.edges_panel(photo.image, photo.pose, shapes), "the plan over it")]


def _resized(values: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Return (h, w) uint8 values at another (height, width), the nearest ones."""
    return cv2.resize(values, size[::-1], interpolation=cv2.INTER_NEAREST)


def _camera_text(camera: Camera) -> str:
    """Return field of view, where it is from, tilt and confidence in a line."""
    fov = np.degrees(2 * np.arctan(camera.width / 2 / camera.focal_px))
    up = camera.matrix[:, 1]
    down = round(-float(np.degrees(np.arcsin(np.clip(up[2], -1, 1)))))
    roll = np.degrees(np.arctan2(up[0], -up[1]))
    source = camera.focal_source.replace("_", " ")
    tilt = f"{abs(down)}° {'down' if down >= 0 else 'up'}, roll {round(float(roll)):+d}°"
    frame = "no frame found" if camera.fallback else tilt
    return f"{fov:.0f}° ({source}), confidence {camera.confidence:.2f}, {frame}"


def _planes_text(planes: Sequence[Plane]) -> str:
    """Return the scale's source and the camera's height in a line."""
    if not planes:
        return ""
    sources = ", ".join(sorted({plane.scale_source.replace("_", " ") for plane in planes}))
    return f"1 m grid; camera at {planes[0].camera_height_m:.2f} m; scale by {sources}"
