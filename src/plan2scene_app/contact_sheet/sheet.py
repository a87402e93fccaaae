"""Contact sheet of a house: a row for each photo shows what each step from photo to crops found.

A row has these panels: the photo with all windows; labels and planes; line segments by axis and the
horizon; rectified planes with a 1 m grid; the plan with the photo's frustum; the plan's edges over
the photo; selected crops and rejected windows with the reason. It is for people to look at: it
draws what the stages saved and computes nothing again.
"""

from __future__ import annotations

import textwrap
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from PIL import Image, ImageDraw

from plan2scene.camera import Camera
from plan2scene.errors import InputError
from plan2scene.house import House
from plan2scene.images import write_png
from plan2scene.photos.camera.lines import SEGMENTS, read_segments
from plan2scene.photos.labels.palette import LABELS, read_label_png
from plan2scene.photos.locate.plan_view import RoomShape, room_shapes
from plan2scene.photos.locate.pose import Pose, read_poses
from plan2scene.photos.photo_files import read_photo
from plan2scene.photos.planes.planes import PhotoPlane, Plane, plane_of_row, read_planes
from plan2scene.stage_json import read_stage_json
from plan2scene_app.contact_sheet import panels
from plan2scene_app.contact_sheet.panels import (
    KINDS,
    REJECTED,
    Window,
    count_windows,
    fit,
    in_turns,
    plane_name,
    read_windows,
    thumbnail,
)
from plan2scene_app.drawing import INK, PAPER, font, font_for, legible, room_labels

#: Largest number of photos on a sheet; further photos are only counted.
MAX_PHOTOS = 20
#: Height and width of a panel, pixels.
PANEL = (225, 300)
#: Width of the panel of crops, and the gap between panels, pixels.
CROPS_WIDTH, GAP = 516, 8
TITLE, CAPTION, HEADER = 20, 18, 44
#: Windows in a row (there is one row of crops and two of rejected windows), side of a window, and
#: height and width of its cell with text, pixels.
COLUMNS, THUMB, CELL = 6, 50, (83, 86)
ROW = TITLE + PANEL[0] + CAPTION + 2 * GAP
#: Number of panels before the panel of crops.
PANELS = 6
WIDTH = PANELS * (PANEL[1] + GAP) + CROPS_WIDTH + 2 * GAP


@dataclass(frozen=True)
class SheetFiles:
    """The files of one house that a contact sheet draws (docs/conventions.md)."""

    crops: str | Path
    candidates: str | Path
    planes: str | Path
    #: Output of the masks stage and cameras.json of the places stage; None where crops are
    #: precomputed.
    masks: str | Path | None = None
    cameras: str | Path | None = None


@dataclass(frozen=True)
class SheetPhoto:
    """One row: the photo reduced to a panel, what the stages found, and a note if it is missing."""

    name: str
    rooms: tuple[str, ...]
    windows: tuple[Window, ...]
    #: (h, w, 3) uint8 sRGB: reduced to a panel, and at the size that the stages use.
    image: np.ndarray | None = None
    full: np.ndarray | None = None
    #: The photo's camera in its own Manhattan frame.
    camera: Camera | None = None
    labels: np.ndarray | None = None
    #: (n, 4) float64, pixels: the line segments from which the camera was estimated.
    segments: np.ndarray | None = None
    planes: tuple[PhotoPlane, ...] = ()
    #: The photo's pose in the house, if it is known.
    pose: Pose | None = None
    note: str = ""


def write_contact_sheet(
    output: str | Path,
    photos: Mapping[str, Path],
    rooms_of_photo: Mapping[str, Sequence[str]],
    files: SheetFiles,
    *,
    house: House,
) -> dict[str, int]:
    """Write the sheet as a PNG and return how many windows are of each kind.

    Parameters
    ----------
    output : path
    photos : mapping of photo name to path
        Photos of the house table, including damaged and missing ones.
    rooms_of_photo : mapping of photo name to room ids
        ``photo_rooms.json`` of the places stage.
    files : SheetFiles
        The files that are drawn.
    house : House
        The plan.

    Returns
    -------
    dict
        ``photos`` (on the sheet), ``selected``, ``last_resort`` and ``rejected`` windows of all
        photos.
    """
    windows = read_windows(files.crops, files.candidates)
    planes = read_planes(files.planes)
    segments = {} if files.masks is None else read_segments(Path(files.masks) / SEGMENTS, "camera")
    poses = {} if files.cameras is None else read_poses(files.cameras, house)
    masks = None if files.masks is None else _Masks.of(Path(files.masks))
    shapes = room_shapes(house)
    labels = room_labels(house)
    names = sorted(set(photos) | set(windows))
    sheet_names = names[:MAX_PHOTOS]
    sheet = Image.new("RGB", (WIDTH, HEADER + ROW * max(1, len(sheet_names))), PAPER)
    all_windows = [window for name in names for window in windows.get(name, ())]
    counts = count_windows(all_windows)
    _header(
        ImageDraw.Draw(sheet),
        legible(house.title, house.id),
        len(names),
        len(sheet_names),
        counts,
        all_windows,
    )

    def row_of(name: str) -> Image.Image:
        rooms = tuple(rooms_of_photo.get(name, ()))
        photo = SheetPhoto(name, rooms, windows.get(name, ()), pose=poses.get(name))
        photo = _with_pixels(photo, photos.get(name), masks, house.id)
        if photo.labels is not None:
            size = (photo.labels.shape[0], photo.labels.shape[1])
            photo_planes = (plane_of_row(row, size) for row in planes.get(name, ()))
            # A photo without a known pose has planes for each of its rooms: show the first room's.
            photo_planes = (
                item for item in photo_planes if item.in_plan or set(rooms[:1]) <= set(item.rooms)
            )
            lines = segments.get(name, np.zeros((0, 4)))
            photo = replace(photo, planes=tuple(photo_planes), segments=lines)
        row = Image.new("RGB", (WIDTH, ROW), PAPER)
        _draw_row(row, photo, labels, row_panels(photo, shapes))
        return row

    for k, name in enumerate(sheet_names):
        sheet.paste(row_of(name), (0, HEADER + k * ROW))
    write_png(output, np.asarray(sheet))
    return {"photos": len(sheet_names), **counts}


@dataclass(frozen=True)
class _Masks:
    """The output of the masks stage: its folder, cameras by photo, warnings."""

    folder: Path
    cameras: Mapping[str, Any]
    warnings: Sequence[str]

    @classmethod
    def of(cls, folder: Path) -> _Masks:
        cameras = read_stage_json(folder / "cameras.json", "cameras")
        return cls(folder, cameras, read_stage_json(folder / "warnings.json", "warnings"))


def _with_pixels(
    photo: SheetPhoto, path: Path | None, masks: _Masks | None, house_id: str
) -> SheetPhoto:
    """Return a photo with its pixels, labels and camera, or with a note why they are missing."""
    if path is None:
        return replace(photo, note="not in the house table")
    try:
        full = read_photo(path, house_id=house_id)
    except InputError as error:
        return replace(photo, note=str(error))
    photo = replace(photo, image=fit(full, PANEL), full=full)
    if masks is None:
        return replace(photo, note="crops come from a folder: no masks, no camera")
    camera = masks.cameras.get(photo.name)
    if camera is None:
        start = f"photo {photo.name} "
        line = next((line for line in masks.warnings if line.startswith(start)), "no mask")
        return replace(photo, note=line)
    labels = read_label_png(masks.folder / f"{Path(photo.name).stem}.png", house_id=house_id)
    return replace(photo, labels=labels, camera=Camera.from_json(camera))


def row_panels(photo: SheetPhoto, shapes: Mapping[str, RoomShape]) -> list[tuple[np.ndarray, str]]:
    """Return a photo's panels with their captions, up to the last step that it reached."""
    if photo.image is None or photo.full is None:
        return []
    height, width = photo.full.shape[:2]
    scale = photo.image.shape[1] / width
    windows = panels.windows_panel(photo.image, photo.windows, scale), f"{width}x{height}"
    if photo.camera is None or photo.labels is None or photo.segments is None:
        return [windows]
    # Lines and planes are drawn at three times the panel's size: enough for a picture, and quick.
    image = fit(photo.full, (3 * PANEL[0], 3 * PANEL[1])) if scale < 1 / 3 else photo.full
    size, small = ((part.shape[0], part.shape[1]) for part in (image, photo.image))
    planes = [item.plane for item in photo.planes]
    located = photo.pose is not None and any(item.in_plan for item in photo.planes)
    camera = photo.pose.camera if photo.pose is not None and located else photo.camera
    segments = (photo.segments + 0.5) * (size[1] / width) - 0.5
    lines = panels.lines_panel(image, photo.camera.resized(size), segments)
    straight = panels.planes_panel(
        image, camera.resized(size), _resized_planes(planes, size), PANEL
    )
    shares = ", ".join(f"{LABELS[k]} {(photo.labels == k).mean():.0%}" for k in (1, 2, 3))
    labels = _resized(photo.labels, small)
    return [
        windows,
        (panels.mask_panel(photo.image, labels, _resized_planes(planes, small)), shares),
        (fit(lines, PANEL), _camera_text(photo.camera)),
        (straight, _planes_text(planes)),
        *_place_panels(photo, shapes),
    ]


def _resized_planes(planes: Sequence[Plane], size: tuple[int, int]) -> list[Plane]:
    """Return planes with their masks resized to (height, width)."""
    return [replace(p, mask=_resized(p.mask.astype(np.uint8), size) > 0) for p in planes]


def _place_panels(
    photo: SheetPhoto, shapes: Mapping[str, RoomShape]
) -> list[tuple[np.ndarray, str]]:
    """Return the plan with the photo's frustum, and the photo with the plan's edges over it."""
    plan = panels.plan_panel(shapes, photo.pose, PANEL)
    if photo.pose is None or photo.image is None:
        return [(plan, "not located")]
    text = f"in {photo.pose.room_id}, located {photo.pose.located:.2f}"
    return [(plan, text), (panels.edges_panel(photo.image, photo.pose, shapes), "the plan over it")]


def _resized(values: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Return (h, w) uint8 values resized to (height, width) by nearest neighbour."""
    return cv2.resize(values, size[::-1], interpolation=cv2.INTER_NEAREST)


def _camera_text(camera: Camera) -> str:
    """Return one line with the field of view, its source, the confidence, tilt and roll."""
    fov = np.degrees(2 * np.arctan(camera.width / 2 / camera.focal_px))
    up = camera.matrix[:, 1]
    down = round(-float(np.degrees(np.arcsin(np.clip(up[2], -1, 1)))))
    roll = np.degrees(np.arctan2(up[0], -up[1]))
    source = camera.focal_source.replace("_", " ")
    tilt = f"{abs(down)}° {'down' if down >= 0 else 'up'}, roll {round(float(roll)):+d}°"
    frame = "no frame found" if camera.fallback else tilt
    return f"{fov:.0f}° ({source}), confidence {camera.confidence:.2f}, {frame}"


def _planes_text(planes: Sequence[Plane]) -> str:
    """Return one line with the camera's height and the source of the scale."""
    if not planes:
        return ""
    sources = ", ".join(sorted({plane.scale_source.replace("_", " ") for plane in planes}))
    return f"1 m grid; camera at {planes[0].camera_height_m:.2f} m; scale by {sources}"


def _header(
    draw: Any,
    title: str,
    n_photos: int,
    n_drawn: int,
    counts: Mapping[str, int],
    windows: Sequence[Window],
) -> None:
    """Write the house's name, the number of windows of each kind, and a legend of the colours."""
    reasons = Counter(part for window in windows if not window.selected for part in window.reasons)
    why = ", ".join(f"{reason} {count}" for reason, count in reasons.most_common(8))
    more = "" if n_drawn == n_photos else f" (the first {n_drawn} shown)"
    text = f"{title}: {n_photos} photos{more}"
    draw.text((GAP, 4), text, font=font_for(text, 17), fill=INK)
    meanings = ("selected", "selected for want of better ones", f"rejected: {why}".rstrip(": "))
    x = GAP
    for (kind, colour), meaning in zip(KINDS.items(), meanings, strict=True):
        text = f"{counts[kind]} {meaning}"
        draw.rectangle((x, 29, x + 9, 38), fill=colour)
        draw.text((x + 14, 27), text, font=font(12), fill=INK)
        x += 14 + round(draw.textlength(text, font=font(12))) + 18


def _draw_row(
    sheet: Any,
    photo: SheetPhoto,
    labels: Mapping[str, str],
    row_panels: Sequence[tuple[np.ndarray, str]],
) -> None:
    """Draw one photo's row; `labels` are room names by id, `row_panels` pictures with captions."""
    draw = ImageDraw.Draw(sheet)
    draw.line((0, 0, WIDTH, 0), fill=(200, 200, 200))
    rooms = ", ".join(labels.get(room, room) for room in photo.rooms) or "no room"
    text = f"{photo.name}  ({rooms})"
    draw.text((GAP, 4), text, font=font_for(text, 13), fill=INK)
    top = TITLE + 2
    for k, (picture, caption) in enumerate(row_panels):
        left = GAP + k * (PANEL[1] + GAP)
        sheet.paste(Image.fromarray(picture), (left, top))
        draw.text((left, top + PANEL[0] + 2), caption, font=font(11), fill=INK)
    if photo.note:
        left = GAP + len(row_panels) * (PANEL[1] + GAP)
        for k, line in enumerate(textwrap.wrap(photo.note, 90)[:6]):
            draw.text((left, top + 4 + 15 * k), line, font=font(12), fill=REJECTED)
    _draw_crops(sheet, (GAP + PANELS * (PANEL[1] + GAP), top), photo)


def _draw_crops(sheet: Any, corner: tuple[int, int], photo: SheetPhoto) -> None:
    """Draw selected crops, then rejected windows with their reasons."""
    draw = ImageDraw.Draw(sheet)
    selected = in_turns([w for w in photo.windows if w.selected])
    out = in_turns([w for w in photo.windows if not w.selected])
    cells = [*enumerate(selected[:COLUMNS]), *enumerate(out[: 2 * COLUMNS], COLUMNS)]
    for cell, window in cells:
        left = corner[0] + cell % COLUMNS * CELL[1]
        top = corner[1] + cell // COLUMNS * CELL[0]
        thumb = thumbnail(window, photo.full, THUMB)
        draw.rectangle((left, top, left + THUMB + 3, top + THUMB + 3), fill=KINDS[window.kind])
        sheet.paste(Image.fromarray(thumb), (left + 2, top + 2))
        for k, line in enumerate(
            [plane_name(window.surface, window.plane), *_reason_lines(draw, window)]
        ):
            draw.text((left, top + THUMB + 4 + 9 * k), line, font=font(9), fill=INK)
    if not selected and photo.camera is not None:
        text = "no crop selected" if out else "no window fits on a plane"
        draw.text((corner[0], corner[1] + 20), text, font=font(12), fill=REJECTED)
    counts = count_windows(photo.windows)
    names = (
        ("selected", "selected"),
        ("last_resort", "for want of better ones"),
        ("rejected", "rejected"),
    )
    text = ", ".join(f"{counts[key]} {name}" for key, name in names)
    draw.text((corner[0], corner[1] - TITLE + 2), text, font=font(13), fill=INK)


def _reason_lines(draw: Any, window: Window) -> list[str]:
    """Return a window's reasons in at most two lines; for a good window, its side in metres."""
    if not window.reasons:
        return [f"{window.size_m:.2f} m"] if np.isfinite(window.size_m) else []
    lines = list(window.reasons[:1])
    for part in window.reasons[1:]:
        longer = f"{lines[-1]}, {part}"
        if draw.textlength(longer, font=font(9)) <= CELL[1] - 4:
            lines[-1] = longer
        else:
            lines.append(part)
    return lines if len(lines) <= 2 else [lines[0] + ",", f"{lines[1]} …"]
