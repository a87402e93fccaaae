"""Contact sheet of a house: for each photo what became of it on the way to crops, in one row.

Photo with all windows drawn, labels and planes, segments by axis with the horizon, planes straight
on with a metre grid, crops kept and windows rejected with the reason. For people to look at.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from plan2scene.drawing import INK, PAPER, font
from plan2scene.errors import InputError
from plan2scene.house import House
from plan2scene.images import write_png
from plan2scene.io import read_json
from plan2scene.photos.camera.calibration import Camera
from plan2scene.photos.contact_sheet import panels
from plan2scene.photos.contact_sheet.panels import fit
from plan2scene.photos.contact_sheet.windows import (
    KEPT,
    LAST_RESORT,
    REJECTED,
    Window,
    count_windows,
    in_turns,
    read_windows,
    thumbnail,
)
from plan2scene.photos.labels.palette import LABELS, read_label_png
from plan2scene.photos.photo_files import read_photo
from plan2scene.photos.planes.planes import DEFAULT_CAMERA_HEIGHT_M, split_planes
from plan2scene.photos.planes.room_size import RoomSize, room_extent

#: Photos on a sheet; of houses with more the first are shown, the rest counted.
MAX_PHOTOS = 20
#: Height and width of a panel, of the crops' panel's width, and of what is between, pixels.
PANEL, CROPS_WIDTH, GAP = (225, 300), 516, 8
TITLE, CAPTION, HEADER = 20, 18, 44
#: Crops and rejected windows shown of one photo, side of one, and of its cell with text.
COLUMNS, KEPT_ROWS, THUMB, CELL = 6, 1, 50, (83, 86)
ROW = TITLE + PANEL[0] + CAPTION + 2 * GAP
WIDTH = 4 * (PANEL[1] + GAP) + CROPS_WIDTH + 2 * GAP


@dataclass(frozen=True)
class _Photo:
    """One row: the photo reduced to a panel, what is known of it, and why it may be missing."""

    name: str
    rooms: tuple[str, ...]
    image: np.ndarray | None
    full: np.ndarray | None
    windows: tuple[Window, ...]
    camera: Camera | None = None
    labels: np.ndarray | None = None
    note: str = ""


def write_contact_sheet(
    output: str | Path,
    photos: Mapping[str, Path],
    rooms_of_photo: Mapping[str, Sequence[str]],
    *,
    house: House,
    masks_dir: str | Path | None,
    crops: str | Path,
    candidates: str | Path,
    camera_height_m: float = DEFAULT_CAMERA_HEIGHT_M,
) -> dict[str, int]:
    """Write the sheet as a PNG and return how many windows are of each kind.

    Parameters
    ----------
    output : path
    photos : mapping of photo name to path
        Photos of the house table, damaged and missing ones too.
    rooms_of_photo : mapping of photo name to room ids
    house : House
        Gives the rooms' heights.
    masks_dir : path, optional
        Output of the masks stage; None where crops are precomputed.
    crops, candidates : path
        ``crops.parquet`` and ``candidates.parquet`` of the house.
    camera_height_m : float
        As the crops were made with, metres.

    Returns
    -------
    dict
        ``photos`` (shown), ``kept``, ``last_resort`` and ``rejected`` windows of all photos.
    """
    from PIL import Image, ImageDraw

    windows = read_windows(crops, candidates)
    names = sorted(set(photos) | set(windows))
    shown = names[:MAX_PHOTOS]
    height = HEADER + ROW * max(1, len(shown))
    sheet = Image.new("RGB", (WIDTH, height), PAPER)
    draw = ImageDraw.Draw(sheet)
    everything = [window for name in names for window in windows.get(name, ())]
    counts = count_windows(everything)
    _header(draw, house.id, len(names), len(shown), counts, everything)
    for row, name in enumerate(shown):
        rooms = tuple(rooms_of_photo.get(name, ()))
        photo = _read(name, photos.get(name), rooms, windows.get(name, ()), masks_dir, house.id)
        room = house.room(rooms[0]) if rooms else None
        room_size = RoomSize(room.height, room_extent(room)) if room else None
        _draw_row(sheet, HEADER + row * ROW, photo, room_size, camera_height_m)
    write_png(output, np.asarray(sheet))
    return {"photos": len(shown), **counts}


def _read(
    name: str,
    path: Path | None,
    rooms: tuple[str, ...],
    windows: Sequence[Window],
    masks_dir: str | Path | None,
    house_id: str,
) -> _Photo:
    """Return a photo with its mask and camera, or with a note why it has none."""
    empty = _Photo(name, rooms, None, None, tuple(windows))
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
    return replace(photo, labels=labels, camera=Camera.from_json(camera))


def _header(
    draw: Any,
    house_id: str,
    n_photos: int,
    n_shown: int,
    counts: Mapping[str, int],
    windows: Sequence[Window],
) -> None:
    """Write the house's name, the counts and the colours' meaning."""
    reasons = Counter(part for window in windows if not window.kept for part in window.reasons)
    why = ", ".join(f"{reason} {count}" for reason, count in reasons.most_common(8))
    more = "" if n_shown == n_photos else f" (the first {n_shown} shown)"
    draw.text((GAP, 4), f"{house_id}: {n_photos} photos{more}", font=font(17), fill=INK)
    pieces = [
        (f"{counts['kept']} crops kept", KEPT),
        (f"{counts['last_resort']} kept for want of better ones", LAST_RESORT),
        (f"{counts['rejected']} rejected" + (f": {why}" if why else ""), REJECTED),
    ]
    x = GAP
    for text, colour in pieces:
        draw.rectangle((x, 29, x + 9, 38), fill=colour)
        draw.text((x + 14, 27), text, font=font(12), fill=INK)
        x += 14 + round(draw.textlength(text, font=font(12))) + 18


def _draw_row(
    sheet: Any, top: int, photo: _Photo, room_size: RoomSize | None, camera_height_m: float
) -> None:
    """Draw one photo's row at `top`."""
    from PIL import Image, ImageDraw

    draw = ImageDraw.Draw(sheet)
    draw.line((0, top, WIDTH, top), fill=(200, 200, 200))
    rooms = ", ".join(photo.rooms) or "no room"
    draw.text((GAP, top + 4), f"{photo.name}  ({rooms})", font=font(13), fill=INK)
    top += TITLE + 2
    found = _panels(photo, room_size, camera_height_m)
    for k, (picture, caption) in enumerate(found):
        left = GAP + k * (PANEL[1] + GAP)
        sheet.paste(Image.fromarray(picture), (left, top))
        draw.text((left, top + PANEL[0] + 2), caption, font=font(11), fill=INK)
    if photo.note:
        left = GAP + len(found) * (PANEL[1] + GAP)
        for k, line in enumerate(_wrapped(photo.note, 90)[:6]):
            draw.text((left, top + 4 + 15 * k), line, font=font(12), fill=REJECTED)
    _draw_crops(sheet, (GAP + 4 * (PANEL[1] + GAP), top), photo)


def _panels(
    photo: _Photo, room_size: RoomSize | None, camera_height_m: float
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
    camera = panels.scaled_camera(photo.camera, size)
    labels = cv2.resize(photo.labels, size[::-1], interpolation=cv2.INTER_NEAREST)
    planes = split_planes(
        labels,
        camera,
        image=image,
        camera_height_m=camera_height_m,
        room_height_m=room_size.height_m if room_size else None,
        room_extent_m=room_size.extent_m if room_size else None,
    )
    small = (photo.image.shape[0], photo.image.shape[1])
    thin = [
        replace(
            plane,
            mask=cv2.resize(
                plane.mask.astype(np.uint8), small[::-1], interpolation=cv2.INTER_NEAREST
            )
            > 0,
        )
        for plane in planes
    ]
    few = cv2.resize(photo.labels, small[::-1], interpolation=cv2.INTER_NEAREST)
    shares = ", ".join(f"{LABELS[k]} {(labels == k).mean():.0%}" for k in (1, 2, 3))
    lines = fit(panels.lines_panel(image, camera), PANEL)
    return [
        *found,
        (panels.mask_panel(photo.image, few, thin), shares),
        (lines, _camera_text(photo.camera)),
        (panels.planes_panel(image, camera, planes, PANEL), _planes_text(planes)),
    ]


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


def _planes_text(planes: Sequence[Any]) -> str:
    """Return the scale's source and the camera's height in a line."""
    if not planes:
        return ""
    sources = ", ".join(sorted({plane.scale_source.replace("_", " ") for plane in planes}))
    return f"1 m grid; camera at {planes[0].camera_height_m:.2f} m; scale by {sources}"


def _draw_crops(sheet: Any, corner: tuple[int, int], photo: _Photo) -> None:
    """Draw kept crops, then rejected windows with their reasons."""
    from PIL import Image, ImageDraw

    draw = ImageDraw.Draw(sheet)
    kept = in_turns([w for w in photo.windows if w.kept])
    out = in_turns([w for w in photo.windows if not w.kept])
    first = kept[: COLUMNS * KEPT_ROWS]
    cells = [*enumerate(first), *enumerate(out[: 2 * COLUMNS], COLUMNS * KEPT_ROWS)]
    for place, window in cells:
        left = corner[0] + place % COLUMNS * CELL[1]
        top = corner[1] + place // COLUMNS * CELL[0]
        thumb = thumbnail(window, photo.full, THUMB)
        draw.rectangle((left, top, left + THUMB + 3, top + THUMB + 3), fill=window.colour)
        sheet.paste(Image.fromarray(thumb), (left + 2, top + 2))
        for k, line in enumerate([window.name, *_reason_lines(draw, window)]):
            draw.text((left, top + THUMB + 4 + 9 * k), line, font=font(9), fill=INK)
    if not kept and photo.camera is not None:
        text = "no crop kept" if out else "no window fits on a plane"
        draw.text((corner[0], corner[1] + 20), text, font=font(12), fill=REJECTED)
    counts = count_windows(photo.windows)
    names = (("kept", "kept"), ("last_resort", "for want of better ones"), ("rejected", "rejected"))
    shown = ", ".join(f"{counts[key]} {name}" for key, name in names)
    draw.text((corner[0], corner[1] - TITLE + 2), shown, font=font(13), fill=INK)


def _reason_lines(draw: Any, window: Window) -> list[str]:
    """Return why a window is not good in at most two lines of a cell's width, else its side."""
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


def _wrapped(text: str, width: int) -> list[str]:
    """Return a text as lines of at most `width` characters."""
    import textwrap

    return textwrap.wrap(text, width, break_long_words=True)
