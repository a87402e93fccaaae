"""Crops of rectified planes, sampled as in the paper, with the metres they cover.

Paper: up to 10 random 256x256 windows fully inside the rectified mask (upscaled by 3), at most
1000 tries each, resized to 128x128; the reference crop of a surface is the medoid. Here windows
are squares in metres, so that the scale of a crop is known.

Terms: a *window* is a square on a plane. A *candidate* is a window that was drawn, with its crop
and the verdict of the filter. *Selected* candidates are the crops of crops.parquet, the *crop
table*. A *precomputed* crop comes from a folder instead. The *reference crop* of a surface is the
medoid of its crops.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import StrEnum
from itertools import product

import cv2
import numpy as np

from plan2scene.camera import Camera
from plan2scene.images import jpeg_bytes
from plan2scene.photos.planes.planes import Plane
from plan2scene.photos.planes.rectification import RectifiedPlane, plane_pixels, rectify
from plan2scene.photos.planes.walls import PLANES

GRAVE = 1.0  #: From this score on a window may show something else than its surface
#: Prefix of the reasons of a bad window that is selected because its surface has no good one.
_LAST_RESORT = "last resort: "
ENOUGH = "enough others"  #: Reason of a good window that is not selected


class Reason(StrEnum):
    """What is wrong with a window, from the worst to the mildest."""

    BORDER = "border"
    CLUTTER = "clutter"
    UNLIKE = "unlike the rest"
    HIGHLIGHT = "highlight"
    SHADOW = "shadow edge"
    # With the following reasons the window shows its surface, but poorly.
    RESTLESS = "restless"
    BLURRED = "not sharp"
    OBLIQUE = "oblique"
    UNKNOWN_DISTANCE = "unknown distance"


_GRAVE_REASONS = tuple(Reason)[:5]


@dataclass(frozen=True)
class Verdict:
    """What is wrong with a window, if anything."""

    reasons: tuple[Reason, ...] = ()  #: from the worst to the mildest; empty for a good window
    #: Order of rejected windows, larger is worse: where a surface has no good window, those of the
    #: lowest score are selected. From `GRAVE` on a window may not show the surface.
    score: float = 0.0

    @classmethod
    def of(cls, reasons: Iterable[Reason], sharpness: float) -> Verdict:
        """Return the verdict on a window for these reasons, in any order.

        Any grave reason weighs more than all mild ones. For the same reasons a sharper crop
        (`sharpness` in photo pixels per crop pixel) has a lower score.
        """
        against = set(reasons)
        if not against:
            return cls()
        grave = len(_GRAVE_REASONS)
        score = sum(
            GRAVE * 2 ** (grave - 1 - rank) if rank < grave else 0.25
            for rank, reason in enumerate(Reason)
            if reason in against
        )
        ordered = tuple(reason for reason in Reason if reason in against)
        return cls(ordered, score + 0.2 * GRAVE / (1.0 + sharpness))

    @property
    def good(self) -> bool:
        """Whether there is no reason against the window."""
        return not self.reasons

    @property
    def grave(self) -> bool:
        """Whether the window may show something else than its surface."""
        return self.score >= GRAVE


def reason_text(verdict: Verdict, *, selected: bool) -> str:
    """Return the cell ``reason`` of candidates.parquet: empty for a good crop.

    `selected` tells whether the window became a crop.
    """
    if verdict.good and not selected:
        return ENOUGH
    text = ", ".join(verdict.reasons)
    return _LAST_RESORT + text if selected and text else text


def reasons_of_text(text: str) -> tuple[str, ...]:
    """Return the reasons of a cell ``reason`` of candidates.parquet."""
    return tuple(part for part in text.removeprefix(_LAST_RESORT).split(", ") if part)


CROP_PX = 128  #: Side of a crop, pixels (paper section 5.2)


@dataclass(frozen=True)
class CropSettings:
    """How windows are drawn; a configuration can set these fields (``crops``)."""

    #: Sides of the windows, metres, tried in this order until a plane has a good window.
    sizes_m: tuple[float, ...] = (1.0, 0.75, 0.5, 0.35)
    #: Largest number of good crops of a plane, and of random draws for each (paper section 5.2).
    per_mask: int = 10
    tries: int = 1000
    #: Prior of the camera's height (`plan2scene.photos.planes.planes.split_planes`), metres.
    camera_height_m: float = PLANES.camera_height_m
    #: Whether windows are judged by :mod:`plan2scene.photos.crops.filter`.
    filter: bool = True


CROPS = CropSettings()


@dataclass(frozen=True)
class SamplingSettings:
    """How windows are drawn and cut. Fields that name no source: chosen on the synthetic homes."""

    #: Largest number of crop pixels per photo pixel (paper: 256 px windows of a x3 image at 128 px
    #: are 1.5). The second value is for planes that are nowhere so sharp: their colour still helps.
    upsampling: tuple[float, float] = (1.5, 3.0)
    #: Least number of pixel positions at which a window fits a plane; else smaller ones are tried.
    least_places: int = 64
    draws_per_crop: int = 3  #: windows drawn per wanted crop, because the filter may reject some
    #: Side of a crop's detail image: its largest value, pixels, and its least ratio to `CROP_PX`.
    detail_px: int = 512
    detail_gain: float = 1.1


SAMPLING = SamplingSettings()


@dataclass(frozen=True)
class Crop:
    """A 128x128 crop of one plane."""

    #: Number within its mask, counted among the candidates (crop table: among the selected ones).
    index: int
    window: tuple[float, float, float, float]  #: (4,): x0 y0 x1 y1 on the rectified plane, metres
    size_m: float  #: side of the window, metres
    #: Photo pixels per crop pixel at its middle (1: as sharp as the photo; 0.5: upsampled x2).
    sharpness: float
    grazing_deg: float  #: angle between the view ray and the plane at its middle, degrees
    image: np.ndarray  #: (128, 128, 3) uint8: sRGB
    #: (8,): x y of the window's corners in the photo, pixels, clockwise from the top left of the
    #: crop.
    corners: tuple[float, ...] = (float("nan"),) * 8
    #: JPEG of the window at the photo's own resolution; empty where the crop loses no resolution.
    detail: bytes = b""


@dataclass(frozen=True)
class Candidate:
    """A window that was drawn: where it is, its crop and the verdict on it."""

    crop: Crop
    verdict: Verdict
    surface: str
    #: Number of the plane (mask) within the photo and surface.
    plane: int
    photo: str = ""
    #: Rooms that the window may show, from its plane: all of one size, or one of a located photo.
    rooms: tuple[str, ...] = ()


#: Judges a window, given the rectified plane; row, column and side in its pixels; and the crop.
Judge = Callable[[RectifiedPlane, int, int, int, Crop], Verdict]


def sample_candidates(
    image: np.ndarray,
    camera: Camera,
    plane: Plane,
    rng: np.random.Generator,
    settings: CropSettings = CROPS,
    judge: Judge | None = None,
) -> list[Candidate]:
    """Return the windows that `rng` draws on a plane of a photo (h, w, 3) uint8 sRGB.

    `judge` says what is wrong with a window; without one all are good.
    """
    candidates: list[Candidate] = []
    wanted = settings.per_mask * (1 if judge is None else SAMPLING.draws_per_crop)
    pixels = plane_pixels(camera, plane)
    for upsampling, size_m in product(SAMPLING.upsampling, settings.sizes_m):
        density = CROP_PX / size_m / upsampling
        rectified = rectify(image, camera, plane, min_density=density, pixels=pixels)
        if rectified is None:
            continue
        good = 0
        side = window_pixels(rectified, size_m)
        for row, column in draw_windows(rectified, side, rng, wanted, settings.tries):
            crop = cut_window(rectified, camera, len(candidates), row, column, size_m)
            verdict = Verdict() if judge is None else judge(rectified, row, column, side, crop)
            candidates.append(Candidate(crop, verdict, plane.surface, plane.index))
            good += verdict.good
            if good == settings.per_mask:
                break
        if good:
            break
    return candidates


def window_pixels(rectified: RectifiedPlane, size_m: float) -> int:
    """Return the side of a window of `size_m` metres in pixels of the rectified image."""
    return max(1, round(size_m / rectified.metres_per_pixel))


def draw_windows(
    rectified: RectifiedPlane, side: int, rng: np.random.Generator, wanted: int, tries: int
) -> list[tuple[int, int]]:
    """Return (row, column) of the top left pixels of random windows fully inside the mask.

    No window is returned twice. There are fewer than `wanted` if draws repeat, or if all of `tries`
    draws for one window miss the mask.
    """
    inside = rectified.places(side)
    if inside.sum() < SAMPLING.least_places:
        return []
    chosen: list[tuple[int, int]] = []
    for _ in range(wanted):
        row = rng.integers(0, inside.shape[0], tries)
        column = rng.integers(0, inside.shape[1], tries)
        hits = np.nonzero(inside[row, column])[0]
        if not len(hits):
            break
        place = (int(row[hits[0]]), int(column[hits[0]]))
        if place not in chosen:
            chosen.append(place)
    return chosen


def cut_window(
    rectified: RectifiedPlane, camera: Camera, index: int, row: int, column: int, size_m: float
) -> Crop:
    """Return one window as a crop."""
    side = window_pixels(rectified, size_m)
    whole = rectified.image[row : row + side, column : column + side]
    way = cv2.INTER_AREA if side > CROP_PX else cv2.INTER_CUBIC
    patch = cv2.resize(whole, (CROP_PX, CROP_PX), interpolation=way)
    window = rectified.window(row, column, side)
    grazing, density = rectified.view((window[0] + window[2]) / 2, (window[1] + window[3]) / 2)
    covered = side * rectified.metres_per_pixel
    return Crop(
        index=index,
        window=window,
        size_m=covered,
        sharpness=density * covered / CROP_PX,
        grazing_deg=grazing,
        image=patch,
        corners=window_corners(rectified, camera, window),
        detail=detail_of(whole, round(density * covered)),
    )


def detail_of(window: np.ndarray, photo_px: int) -> bytes:
    """Return a window (s, s, 3) as JPEG at the photo's resolution; empty if a crop has as much.

    `photo_px` is the number of photo pixels along the window's side.
    """
    side = min(len(window), photo_px, SAMPLING.detail_px)
    if side < SAMPLING.detail_gain * CROP_PX:
        return b""
    if side < len(window):
        window = cv2.resize(window, (side, side), interpolation=cv2.INTER_AREA)
    return jpeg_bytes(window, quality=95, full_colour=True)


def window_corners(
    rectified: RectifiedPlane, camera: Camera, window: tuple[float, float, float, float]
) -> tuple[float, ...]:
    """Return x y in the photo (8 floats, pixels) of a window's corners.

    They go clockwise from the top left of the rectified image; in the photo those of a ceiling go
    anticlockwise.
    """
    x0, y0, x1, y1 = window
    flat = np.array([[x0, y0, 1.0], [x1, y0, 1.0], [x1, y1, 1.0], [x0, y1, 1.0]])
    image = flat @ rectified.axes @ (camera.intrinsics @ camera.matrix).T
    return tuple(float(value) for value in (image[:, :2] / image[:, 2:]).ravel())
