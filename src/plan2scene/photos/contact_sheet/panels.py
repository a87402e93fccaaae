"""Panels of a contact sheet: what each step from photo to crops saw, drawn on a small photo.

Every function takes a photo already reduced to the panel (and a camera to match) and returns a
new (h, w, 3) uint8 sRGB picture; nothing here decides anything.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np
from PIL import Image, ImageDraw

from plan2scene.camera import Camera
from plan2scene.drawing import INK, PAPER, font
from plan2scene.photos.camera.lines import detect_segments
from plan2scene.photos.camera.vanishing import Segments, residuals
from plan2scene.photos.contact_sheet.windows import KINDS, Window, plane_name
from plan2scene.photos.labels.palette import overlay
from plan2scene.photos.planes.planes import Plane
from plan2scene.photos.planes.rectification import RectifiedPlane, rectify

#: sRGB of segments along the photo's x, y (up) and z, of other segments, and of the horizon.
AXES = ((235, 70, 60), (60, 190, 80), (70, 130, 250))
STRAY, HORIZON = (150, 150, 150), (255, 220, 0)
#: A segment belongs to an axis that it misses by less than this, degrees.
AXIS_DEG = 3.0
#: Rectified planes shown of one photo, the largest first.
MAX_PLANES = 6


def fit(image: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Return an image reduced or enlarged to fit (height, width), its shape kept."""
    height, width = image.shape[:2]
    scale = min(size[0] / height, size[1] / width)
    shape = (max(1, round(width * scale)), max(1, round(height * scale)))
    way = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
    return cv2.resize(image, shape, interpolation=way)


def scaled_camera(camera: Camera, size: tuple[int, int]) -> Camera:
    """Return the camera of the photo resized to (height, width)."""
    scale = size[1] / camera.width
    return replace(
        camera,
        width=size[1],
        height=size[0],
        focal_px=camera.focal_px * scale,
        cx=(camera.cx + 0.5) * scale - 0.5,
        cy=(camera.cy + 0.5) * size[0] / camera.height - 0.5,
    )


def windows_panel(image: np.ndarray, windows: Sequence[Window], scale: float) -> np.ndarray:
    """Return the photo with the windows' outlines; `scale` is its size over the full photo's."""
    picture = image.copy()
    for kept in (False, True):
        layer = picture.copy()
        for window in windows:
            if window.kept == kept and np.isfinite(window.corners).all():
                points = np.rint((window.corners + 0.5) * scale * 8).astype(np.int32)
                cv2.polylines(layer, [points], True, KINDS[window.kind], 1, cv2.LINE_AA, 3)
        # Rejected windows are many: they must not hide the photo.
        opacity = 1.0 if kept else 0.4
        picture = cv2.addWeighted(layer, opacity, picture, 1.0 - opacity, 0.0)
    return picture


def mask_panel(image: np.ndarray, labels: np.ndarray, planes: Sequence[Plane]) -> np.ndarray:
    """Return the photo under its labels' colours, planes outlined and named (f, c, w0 ...)."""
    picture = overlay(image, labels, opacity=0.45)
    masks = [plane.mask.astype(np.uint8) for plane in planes]
    for mask in masks:
        found, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        cv2.drawContours(picture, found, -1, (255, 255, 255), 1)
    for plane, mask in zip(planes, masks, strict=True):
        depth = cv2.distanceTransform(np.pad(mask, 1), cv2.DIST_L2, cv2.DIST_MASK_5)
        row, column = np.unravel_index(int(np.argmax(depth)), depth.shape)
        _tag(picture, plane_name(plane.surface, plane.index), (int(column), int(row)))
    return picture


def _tag(picture: np.ndarray, text: str, middle: tuple[int, int]) -> None:
    """Write a small label into `picture`, centred on a pixel as far as it stays inside."""
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


def lines_panel(image: np.ndarray, camera: Camera) -> np.ndarray:
    """Return the photo, paled, with its line segments by axis and the horizon."""
    picture = np.clip(image * 0.45 + 255 * 0.55, 0, 255).astype(np.uint8)
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    segments = detect_segments(grey)[:320]
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
    """Return the axis (0 x, 1 up, 2 z) that each segment (n, 4) runs along, or -1, as (n,) int."""
    lines = Segments(segments, (camera.cx, camera.cy), np.ones(len(segments)))
    turn = np.abs(residuals(*lines.rays(camera.focal_px), camera.matrix))
    nearest = np.argmin(turn, axis=1)
    return np.where(turn.min(axis=1) < np.radians(AXIS_DEG), nearest, -1)


def planes_panel(
    image: np.ndarray, camera: Camera, planes: Sequence[Plane], size: tuple[int, int]
) -> np.ndarray:
    """Return a picture of (height, width) with the largest planes straight on, metre grid over."""
    shown = sorted(planes, key=lambda plane: -int(plane.mask.sum()))[:MAX_PLANES]
    seen = [(plane, found) for plane in shown if (found := rectify(image, camera, plane))]
    canvas = Image.new("RGB", (size[1], size[0]), PAPER)
    draw = ImageDraw.Draw(canvas)
    if not seen:
        draw.text((size[1] // 2, size[0] // 2), "no plane", font=font(12), fill=INK, anchor="mm")
        return np.array(canvas)
    columns = 1 if len(seen) == 1 else 2 if len(seen) <= 4 else 3
    rows = -(-len(seen) // columns)
    cell = (size[0] // rows, size[1] // columns)
    for k, (plane, found) in enumerate(seen):
        left, top = (k % columns) * cell[1], (k // columns) * cell[0]
        thumb = _with_grid(found, (cell[0] - 18, cell[1] - 6))
        canvas.paste(Image.fromarray(thumb), (left + 2, top + 15))
        rows_m, columns_m = (side * found.metres_per_pixel for side in found.mask.shape)
        text = f"{plane_name(plane.surface, plane.index)}, {columns_m:.1f} x {rows_m:.1f} m"
        draw.text((left + 2, top + 1), text, font=font(10), fill=INK)
    return np.array(canvas)


def _with_grid(found: RectifiedPlane, size: tuple[int, int]) -> np.ndarray:
    """Return a rectified plane at most (height, width) large, unusable parts pale, metre lines."""
    image = np.where(found.mask[..., None], found.image, found.image // 4 + 180)
    thumb = fit(image.astype(np.uint8), size)
    scale = thumb.shape[1] / found.mask.shape[1]
    for axis in (0, 1):
        start = found.origin[axis]
        extent = found.mask.shape[1 - axis] * found.metres_per_pixel
        for metre in range(int(np.ceil(start)), int(np.floor(start + extent)) + 1):
            place = min(
                round((metre - start) / found.metres_per_pixel * scale), thumb.shape[1 - axis] - 1
            )
            line = thumb[:, place] if axis == 0 else thumb[place]
            line[:] = (line.astype(int) + (255, 0, 255)) // 2
    return thumb
