"""Panels of a contact sheet: pictures of what each step from photo to crops found.

The drawing functions take a photo that is already reduced to the panel, with a matching camera, and
return a new (h, w, 3) uint8 sRGB picture. They only draw results of the stages.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise, zip_longest
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from PIL import Image, ImageDraw

from plan2scene.camera import Camera
from plan2scene.images import image_from_bytes
from plan2scene.io import read_parquet
from plan2scene.photos.camera.lines import Segments, residuals
from plan2scene.photos.crops.sampling import reasons_of_text
from plan2scene.photos.labels.palette import PALETTE
from plan2scene.photos.locate.plan_view import Hole, RoomShape
from plan2scene.photos.locate.pose import Pose
from plan2scene.photos.planes.planes import Plane
from plan2scene.photos.planes.rectification import RectifiedPlane, rectify
from plan2scene_app.drawing import INK, PAPER, font

#: sRGB of windows that are selected, selected for lack of better ones, and rejected.
SELECTED, LAST_RESORT, REJECTED = (40, 200, 70), (250, 170, 30), (225, 50, 50)
#: The kinds of windows, with their colours.
KINDS = {"selected": SELECTED, "last_resort": LAST_RESORT, "rejected": REJECTED}


@dataclass(frozen=True)
class Window:
    """One candidate for a crop: a square window on a plane of a photo."""

    surface: str
    plane: int
    selected: bool
    #: Why the window is not good; empty for a good one.
    reasons: tuple[str, ...]
    #: Side in metres, NaN where unknown.
    size_m: float
    #: (4, 2) float64: Pixels x, y in the photo, clockwise from the crop's top left; NaN where
    #: unknown.
    corners: np.ndarray
    #: (128, 128, 3) uint8: The crop of a selected window.
    image: np.ndarray | None = None

    @property
    def kind(self) -> str:
        """Return the window's kind, a key of `KINDS`."""
        return "rejected" if not self.selected else "last_resort" if self.reasons else "selected"


def plane_name(surface: str, index: int) -> str:
    """Return a short name of a plane: floor, ceiling, wall 0 ..."""
    return f"wall {index}" if surface == "wall" else surface


def read_windows(crops: str | Path, candidates: str | Path) -> dict[str, tuple[Window, ...]]:
    """Return each photo's windows, each once; it is selected if at least one room selects it."""
    table, _ = read_parquet(crops)
    png = dict(zip(table["crop_id"], table["png"], strict=True))
    frame, _ = read_parquet(candidates)
    windows: dict[tuple[str, str, int, int], Window] = {}
    for row in frame.to_dict("records"):
        key = (row["photo"], row["surface"], int(row["plane"]), int(row["index"]))
        if key in windows and windows[key].selected:
            continue
        windows[key] = _window(row, png)
    photos: dict[str, list[Window]] = {}
    for (photo, *_), window in windows.items():
        photos.setdefault(photo, []).append(window)
    return {photo: tuple(members) for photo, members in photos.items()}


def _window(row: Mapping[str, Any], png: Mapping[str, bytes]) -> Window:
    """Return the window of a row of candidates.parquet."""
    data = png.get(row["crop_id"]) if row["crop_id"] else None
    return Window(
        surface=row["surface"],
        plane=int(row["plane"]),
        selected=bool(row["crop_id"]),
        reasons=reasons_of_text(row["reason"]),
        size_m=float(row["metres"]),
        corners=np.array(list(row["corners"]), np.float64).reshape(4, 2),
        image=None if data is None else image_from_bytes(data),
    )


def count_windows(windows: Sequence[Window]) -> dict[str, int]:
    """Return how many windows are of each kind."""
    kinds = [window.kind for window in windows]
    return {kind: kinds.count(kind) for kind in KINDS}


def thumbnail(window: Window, full: np.ndarray | None, side: int) -> np.ndarray:
    """Return a window's picture (side, side, 3): its crop, or cut from the photo at its corners."""
    if window.image is not None:
        return cv2.resize(window.image, (side, side), interpolation=cv2.INTER_AREA)
    if full is None or not np.isfinite(window.corners).all():
        return np.full((side, side, 3), 220, np.uint8)
    large = 2 * side
    square = np.array([[0, 0], [large, 0], [large, large], [0, large]], np.float32) - 0.5
    warp = cv2.getPerspectiveTransform(window.corners.astype(np.float32), square)
    cut = cv2.warpPerspective(full, warp, (large, large))
    return cv2.resize(cut, (side, side), interpolation=cv2.INTER_AREA)


def in_turns(windows: Sequence[Window]) -> list[Window]:
    """Return windows alternating between planes and reasons, so that the first show every kind."""
    groups: dict[tuple[str, int, tuple[str, ...]], list[Window]] = {}
    for window in windows:
        groups.setdefault((window.surface, window.plane, window.reasons), []).append(window)
    turns = zip_longest(*(groups[name] for name in sorted(groups)))
    return [window for turn in turns for window in turn if window is not None]


#: sRGB of segments along the photo's x, y (up) and z, of other segments, and of the horizon.
AXES = ((235, 70, 60), (60, 190, 80), (70, 130, 250))
STRAY, HORIZON = (150, 150, 150), (255, 220, 0)
#: A segment belongs to an axis if the angle between them is less than this, degrees.
AXIS_DEG = 3.0
#: Largest number of rectified planes that are shown for one photo, the largest first.
MAX_PLANES = 6


def fit(image: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Return an image scaled to fit into (height, width), with its aspect ratio kept."""
    height, width = image.shape[:2]
    scale = min(size[0] / height, size[1] / width)
    shape = (max(1, round(width * scale)), max(1, round(height * scale)))
    way = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
    return cv2.resize(image, shape, interpolation=way)


def windows_panel(image: np.ndarray, windows: Sequence[Window], scale: float) -> np.ndarray:
    """Return the photo with the windows' outlines; `scale` is image size over full photo size."""
    picture = image.copy()
    for selected in (False, True):
        layer = picture.copy()
        for window in windows:
            if window.selected == selected and np.isfinite(window.corners).all():
                points = np.rint((window.corners + 0.5) * scale * 8).astype(np.int32)
                cv2.polylines(layer, [points], True, KINDS[window.kind], 1, cv2.LINE_AA, 3)
        # There are many rejected windows: they are drawn pale so that they do not hide the photo.
        opacity = 1.0 if selected else 0.4
        picture = cv2.addWeighted(layer, opacity, picture, 1.0 - opacity, 0.0)
    return picture


def mask_panel(image: np.ndarray, labels: np.ndarray, planes: Sequence[Plane]) -> np.ndarray:
    """Return the photo tinted by its labels; planes are outlined and named (floor, wall 0 ...)."""
    table = np.zeros((256, 3), np.float32)
    table[: len(PALETTE)] = PALETTE
    mixed = 0.55 * image.astype(np.float32) + 0.45 * table[labels]
    picture = np.round(mixed).astype(np.uint8)
    masks = [plane.mask.astype(np.uint8) for plane in planes]
    for mask in masks:
        contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        cv2.drawContours(picture, contours, -1, (255, 255, 255), 1)
    for plane, mask in zip(planes, masks, strict=True):
        depth = cv2.distanceTransform(np.pad(mask, 1), cv2.DIST_L2, cv2.DIST_MASK_5)
        row, column = np.unravel_index(int(np.argmax(depth)), depth.shape)
        _tag(picture, plane_name(plane.surface, plane.index), (int(column), int(row)))
    return picture


def _tag(picture: np.ndarray, text: str, middle: tuple[int, int]) -> None:
    """Write a small label into `picture`, centred on a pixel but moved to stay inside."""
    canvas = Image.fromarray(picture)
    draw = ImageDraw.Draw(canvas)
    half = draw.textlength(text, font=font(11)) / 2 + 3
    middle = (
        round(np.clip(middle[0], half, max(half, canvas.width - half))),
        round(np.clip(middle[1], 8, max(8, canvas.height - 8))),
    )
    box = draw.textbbox(middle, text, font=font(11), anchor="mm")
    draw.rectangle((box[0] - 2, box[1] - 1, box[2] + 2, box[3] + 1), fill=(0, 0, 0))
    draw.text(middle, text, font=font(11), fill=(255, 255, 255), anchor="mm")
    picture[:] = np.asarray(canvas)


def lines_panel(image: np.ndarray, camera: Camera, segments: np.ndarray) -> np.ndarray:
    """Return the pale photo with its line segments (n, 4), coloured by axis, and the horizon."""
    picture = np.clip(image * 0.45 + 255 * 0.55, 0, 255).astype(np.uint8)
    for segment, axis in zip(segments, segment_axes(segments, camera), strict=True):
        ends = np.rint(segment.reshape(2, 2) * 8).astype(int)
        colour = STRAY if axis < 0 else AXES[axis]
        start, end = ((int(x), int(y)) for x, y in ends)
        cv2.line(picture, start, end, colour, 1 if axis < 0 else 2, cv2.LINE_AA, 3)
    horizon = np.linalg.inv(camera.intrinsics).T @ camera.matrix[:, 1]
    if abs(horizon[1]) > 1e-9:
        left, right = (-(horizon[0] * x + horizon[2]) / horizon[1] for x in (0, camera.width - 1))
        if max(abs(left), abs(right)) < 10 * camera.height:
            start, end = (0, round(left)), (camera.width - 1, round(right))
            cv2.line(picture, start, end, HORIZON, 2, cv2.LINE_AA)
    return picture


def segment_axes(segments: np.ndarray, camera: Camera) -> np.ndarray:
    """Return the axis (0 x, 1 up, 2 z) of each segment (n, 4), -1 for none, as (n,) int."""
    lines = Segments(segments, (camera.cx, camera.cy), np.ones(len(segments)))
    turn = np.abs(residuals(*lines.rays(camera.focal_px), camera.matrix))
    nearest = np.argmin(turn, axis=1)
    return np.where(turn.min(axis=1) < np.radians(AXIS_DEG), nearest, -1)


def planes_panel(
    image: np.ndarray, camera: Camera, planes: Sequence[Plane], size: tuple[int, int]
) -> np.ndarray:
    """Return a picture (height, width) of the largest planes, rectified, with a 1 m grid."""
    largest = sorted(planes, key=lambda plane: -int(plane.mask.sum()))[:MAX_PLANES]
    views = [(plane, view) for plane in largest if (view := rectify(image, camera, plane))]
    canvas = Image.new("RGB", (size[1], size[0]), PAPER)
    draw = ImageDraw.Draw(canvas)
    if not views:
        draw.text((size[1] // 2, size[0] // 2), "no plane", font=font(12), fill=INK, anchor="mm")
        return np.array(canvas)
    columns = 1 if len(views) == 1 else 2 if len(views) <= 4 else 3
    rows = -(-len(views) // columns)
    cell = (size[0] // rows, size[1] // columns)
    for k, (plane, view) in enumerate(views):
        left, top = (k % columns) * cell[1], (k // columns) * cell[0]
        thumb = _with_grid(view, (cell[0] - 18, cell[1] - 6))
        canvas.paste(Image.fromarray(thumb), (left + 2, top + 15))
        rows_m, columns_m = (side * view.metres_per_pixel for side in view.mask.shape)
        text = f"{plane_name(plane.surface, plane.index)}, {columns_m:.1f} x {rows_m:.1f} m"
        draw.text((left + 2, top + 1), text, font=font(10), fill=INK)
    return np.array(canvas)


def _with_grid(view: RectifiedPlane, size: tuple[int, int]) -> np.ndarray:
    """Return a rectified plane that fits (height, width), invalid parts pale, with a 1 m grid."""
    image = np.where(view.mask[..., None], view.image, view.image // 4 + 180)
    thumb = fit(image.astype(np.uint8), size)
    scale = thumb.shape[1] / view.mask.shape[1]
    for axis in (0, 1):
        start = view.origin[axis]
        extent = view.mask.shape[1 - axis] * view.metres_per_pixel
        for metre in range(int(np.ceil(start)), int(np.floor(start + extent)) + 1):
            place = min(
                round((metre - start) / view.metres_per_pixel * scale), thumb.shape[1 - axis] - 1
            )
            line = thumb[:, place] if axis == 0 else thumb[place]
            line[:] = (line.astype(int) + (255, 0, 255)) // 2
    return thumb


#: sRGB of walls, doors and passages, windows, the frustum, and the room of the camera.
WALL_INK, DOOR_INK, WINDOW_INK = (90, 90, 90), (220, 60, 50), (40, 140, 235)
FRUSTUM, OWN_ROOM = (240, 150, 30), (255, 243, 214)
#: Length of the frustum in the plan, metres, and the margin around the plan, pixels.
FRUSTUM_M, MARGIN = 2.5, 8
#: Depth of the near plane at which lines are clipped, metres.
NEAR_M = 0.05


def plan_panel(
    shapes: Mapping[str, RoomShape], pose: Pose | None, size: tuple[int, int]
) -> np.ndarray:
    """Return a picture of (height, width) of the plan, x to the right and z down.

    It shows the level where the photo was taken, with the frustum. Without a pose it shows the
    level of the first shape.
    """
    level = next(iter(shapes.values())).level if pose is None else shapes[pose.room_id].level
    shapes = {name: shape for name, shape in shapes.items() if shape.level == level}
    picture = np.full((*size, 3), PAPER, np.uint8)
    points = np.concatenate([shape.start for shape in shapes.values()])
    low, span = points.min(axis=0), np.maximum(np.ptp(points, axis=0), 0.1)
    scale = float(((np.array([size[1], size[0]]) - 2 * MARGIN) / span).min())

    def pixels(plan: np.ndarray) -> np.ndarray:
        return np.rint(((plan - low) * scale + MARGIN) * 8).astype(np.int32)

    if pose is not None:
        cv2.fillPoly(picture, [pixels(shapes[pose.room_id].start)], OWN_ROOM, cv2.LINE_AA, 3)
    for shape in shapes.values():
        ends = shape.start + shape.along * shape.length[:, None]
        for a, b in zip(shape.start, ends, strict=True):
            cv2.line(picture, pixels(a), pixels(b), WALL_INK, 1, cv2.LINE_AA, 3)
        for hole in shape.holes:
            a, b = (shape.start[hole.edge] + at * shape.along[hole.edge] for at in _ends(hole))
            cv2.line(picture, pixels(a), pixels(b), _ink(hole), 2, cv2.LINE_AA, 3)
    if pose is not None:
        rays = pose.camera.rays(
            np.array([[0.0, pose.camera.cy], [pose.camera.width - 1.0, pose.camera.cy]])
        )[:, [0, 2]]
        eye = pose.eye[[0, 2]]
        rim = eye + FRUSTUM_M * rays / np.linalg.norm(rays, axis=1, keepdims=True)
        corners = pixels(np.stack([eye, *rim]))
        layer = picture.copy()
        cv2.fillPoly(layer, [corners], FRUSTUM, cv2.LINE_AA, 3)
        picture = cv2.addWeighted(layer, 0.35, picture, 0.65, 0.0)
        cv2.circle(picture, corners[0], 3 * 8, FRUSTUM, -1, cv2.LINE_AA, 3)
    return picture


def edges_panel(image: np.ndarray, pose: Pose, shapes: Mapping[str, RoomShape]) -> np.ndarray:
    """Return a photo (h, w, 3) with the edges of its room in the plan drawn over it."""
    camera = pose.camera.resized((image.shape[0], image.shape[1]))
    picture = np.clip(image * 0.7 + 255 * 0.3, 0, 255).astype(np.uint8)
    for line, ink in _room_lines(shapes[pose.room_id]):
        for a, b in _segments(camera, line - pose.eye):
            cv2.line(picture, a, b, ink, 2 if ink != WALL_INK else 1, cv2.LINE_AA, 3)
    return picture


def _room_lines(shape: RoomShape) -> Iterator[tuple[np.ndarray, tuple[int, int, int]]]:
    """Yield the room's edges and openings as world points (n, 3), metres, with their colours."""

    def at(plan: np.ndarray, y: float) -> np.ndarray:
        return np.array([plan[0], y, plan[1]])

    ends = shape.start + shape.along * shape.length[:, None]
    for a, b in zip(shape.start, ends, strict=True):
        ring = [at(a, 0.0), at(b, 0.0), at(b, shape.height), at(a, shape.height), at(a, 0.0)]
        yield np.array(ring), WALL_INK
    for hole in shape.holes:
        a, b = (shape.start[hole.edge] + s * shape.along[hole.edge] for s in _ends(hole))
        low, high = hole.bottom, hole.top
        yield np.array([at(a, low), at(b, low), at(b, high), at(a, high), at(a, low)]), _ink(hole)


def _segments(
    camera: Camera, points: np.ndarray
) -> Iterator[tuple[tuple[int, int], tuple[int, int]]]:
    """Yield a line's visible pieces in 1/8 pixels; its points (n, 3) are relative to the eye."""
    in_camera = camera.seen(points)
    for a, b in pairwise(in_camera):
        if max(a[2], b[2]) <= NEAR_M:
            continue
        if min(a[2], b[2]) < NEAR_M:
            cut = a + (b - a) * (NEAR_M - a[2]) / (b[2] - a[2])
            a, b = (a, cut) if a[2] > b[2] else (cut, b)
        flat = np.stack([p[:2] / p[2] * camera.focal_px + (camera.cx, camera.cy) for p in (a, b)])
        flat = np.clip(np.rint(flat * 8), -1e7, 1e7).astype(int)
        yield (int(flat[0, 0]), int(flat[0, 1])), (int(flat[1, 0]), int(flat[1, 1]))


def _ends(hole: Hole) -> tuple[float, float]:
    return hole.start, hole.end


def _ink(hole: Hole) -> tuple[int, int, int]:
    return WINDOW_INK if hole.kind == "window" else DOOR_INK
