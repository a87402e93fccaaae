"""Contact sheet of a house: for each photo what became of it on the way to crops, in one row.

Photo with all windows drawn, labels and planes, segments by axis with the horizon, planes straight
on with a metre grid, the plan with the photo's frustum and its edges over the photo, crops kept and
windows rejected with the reason. For people to look at.
"""

from __future__ import annotations

import textwrap
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw

from plan2scene.drawing import INK, PAPER, font
from plan2scene.house import House
from plan2scene.images import write_png
from plan2scene.parallel import each
from plan2scene.photos.contact_sheet.rows import PANEL, SheetPhoto, row_panels, sheet_photo
from plan2scene.photos.contact_sheet.windows import (
    KINDS,
    REJECTED,
    Window,
    count_windows,
    in_turns,
    plane_name,
    read_windows,
    thumbnail,
)
from plan2scene.photos.locate.plan_view import room_shapes
from plan2scene.photos.locate.stage import read_poses
from plan2scene.photos.planes.planes import DEFAULT_CAMERA_HEIGHT_M
from plan2scene.photos.planes.room_size import RoomSize

#: Photos on a sheet; of houses with more the first are shown, the rest counted.
MAX_PHOTOS = 20
#: Width of the crops' panel, and of what is between panels, pixels.
CROPS_WIDTH, GAP = 516, 8
TITLE, CAPTION, HEADER = 20, 18, 44
#: Windows in a row (one of crops, two of rejected ones), side of one, and of its cell with text.
COLUMNS, THUMB, CELL = 6, 50, (83, 86)
ROW = TITLE + PANEL[0] + CAPTION + 2 * GAP
#: Panels before the crops.
PANELS = 6
WIDTH = PANELS * (PANEL[1] + GAP) + CROPS_WIDTH + 2 * GAP


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
    cameras: str | Path | None = None,
    threads: int = 1,
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
    cameras : path, optional
        ``cameras.json`` of the locate stage.
    threads : int
        Rows drawn at a time; the sheet does not depend on it.

    Returns
    -------
    dict
        ``photos`` (shown), ``kept``, ``last_resort`` and ``rejected`` windows of all photos.
    """
    windows = read_windows(crops, candidates)
    poses = {} if cameras is None else read_poses(cameras)
    shapes = room_shapes(house)
    names = sorted(set(photos) | set(windows))
    shown = names[:MAX_PHOTOS]
    height = HEADER + ROW * max(1, len(shown))
    sheet = Image.new("RGB", (WIDTH, height), PAPER)
    draw = ImageDraw.Draw(sheet)
    everything = [window for name in names for window in windows.get(name, ())]
    counts = count_windows(everything)
    _header(draw, house.id, len(names), len(shown), counts, everything)

    def row_of(name: str) -> np.ndarray:
        rooms = tuple(rooms_of_photo.get(name, ()))
        if not rooms and name in poses:
            rooms = (poses[name].room_id,)
        photo = sheet_photo(
            name,
            photos.get(name),
            rooms,
            windows.get(name, ()),
            masks_dir,
            house.id,
            poses.get(name),
        )
        room_size = RoomSize.of(house.room(rooms[0])) if rooms else None
        row = Image.new("RGB", (WIDTH, ROW), PAPER)
        _draw_row(row, photo, row_panels(photo, room_size, camera_height_m, shapes))
        return np.asarray(row)

    for k, pixels in enumerate(each(row_of, shown, threads)):
        sheet.paste(Image.fromarray(pixels), (0, HEADER + k * ROW))
    write_png(output, np.asarray(sheet))
    return {"photos": len(shown), **counts}


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
    meanings = ("crops kept", "kept for want of better ones", f"rejected: {why}".rstrip(": "))
    x = GAP
    for (kind, colour), meaning in zip(KINDS.items(), meanings, strict=True):
        text = f"{counts[kind]} {meaning}"
        draw.rectangle((x, 29, x + 9, 38), fill=colour)
        draw.text((x + 14, 27), text, font=font(12), fill=INK)
        x += 14 + round(draw.textlength(text, font=font(12))) + 18


def _draw_row(sheet: Any, photo: SheetPhoto, found: Sequence[tuple[np.ndarray, str]]) -> None:
    """Draw one photo's row, `found` being its panels with their captions."""
    draw = ImageDraw.Draw(sheet)
    draw.line((0, 0, WIDTH, 0), fill=(200, 200, 200))
    rooms = ", ".join(photo.rooms) or "no room"
    draw.text((GAP, 4), f"{photo.name}  ({rooms})", font=font(13), fill=INK)
    top = TITLE + 2
    for k, (picture, caption) in enumerate(found):
        left = GAP + k * (PANEL[1] + GAP)
        sheet.paste(Image.fromarray(picture), (left, top))
        draw.text((left, top + PANEL[0] + 2), caption, font=font(11), fill=INK)
    if photo.note:
        left = GAP + len(found) * (PANEL[1] + GAP)
        for k, line in enumerate(textwrap.wrap(photo.note, 90)[:6]):
            draw.text((left, top + 4 + 15 * k), line, font=font(12), fill=REJECTED)
    _draw_crops(sheet, (GAP + PANELS * (PANEL[1] + GAP), top), photo)


def _draw_crops(sheet: Any, corner: tuple[int, int], photo: SheetPhoto) -> None:
    """Draw kept crops, then rejected windows with their reasons."""
    draw = ImageDraw.Draw(sheet)
    kept = in_turns([w for w in photo.windows if w.kept])
    out = in_turns([w for w in photo.windows if not w.kept])
    cells = [*enumerate(kept[:COLUMNS]), *enumerate(out[: 2 * COLUMNS], COLUMNS)]
    for place, window in cells:
        left = corner[0] + place % COLUMNS * CELL[1]
        top = corner[1] + place // COLUMNS * CELL[0]
        thumb = thumbnail(window, photo.full, THUMB)
        draw.rectangle((left, top, left + THUMB + 3, top + THUMB + 3), fill=KINDS[window.kind])
        sheet.paste(Image.fromarray(thumb), (left + 2, top + 2))
        for k, line in enumerate(
            [plane_name(window.surface, window.plane), *_reason_lines(draw, window)]
        ):
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
