"""Find walls in bands: up to some height all walls of a room have another colour.

Tiles, panels and paint end sharply at one height, while light fades and seldom changes its colour.
So a band is accepted only if the colour steps at one height along most of a wall, and if several
views of the room's walls agree on that height.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import PurePath

import cv2
import numpy as np

from plan2scene.colour import srgb_to_linear
from plan2scene.photos.patterns.views import PhotoPlanes
from plan2scene.photos.planes.rectification import rectify


@dataclass(frozen=True)
class BandSettings:
    """Constants chosen on synthetic walls and on two development homes without bands."""

    photo_px: int = 900  #: longer side to which a photo is reduced
    px_per_m: float = 40.0  #: resolution of the rectified walls
    column_m: float = 0.1  #: width of the columns whose colours are compared
    strip_m: float = 0.16  #: height of the strips that are compared above and below a step
    gap_m: float = 0.04  #: gap between the step and the strip on either side
    heights_m: tuple[float, float] = (0.45, 2.1)  #: range of a step's height above the floor
    #: Largest height of a step outside bathrooms (dados, low panels); the tiles of bathrooms may
    #: reach up to a door's head.
    dry_m: float = 1.6
    least_m: float = 0.8  #: least width over which a view shows a step
    step: float = 0.25  #: least change of log colour, with brightness counted half
    along: float = 0.75  #: least share of the columns whose step is like the median one
    sharp: float = 2.5  #: least ratio of a step to the change within its strips
    same: float = 0.12  #: log ratio by which heights in located photos of a room may differ
    unplaced: float = 0.35  #: the same for other photos, whose camera is assumed 1.5 m high
    views: int = 2  #: least number of views with the step, of one wall or of several
    most: float = 0.6  #: least share of the width seen at the step's height that shows it


BANDS = BandSettings()
#: Heights at which steps are looked for, metres.
_HEIGHTS = np.arange(*BANDS.heights_m, 1 / BANDS.px_per_m)
_GREY = np.full(3, 1 / 3)


@dataclass(frozen=True, eq=False)
class WallView:
    """A wall in one photo, seen straight on."""

    photo: str
    room: str
    plane: str  #: name of the plane; the ids of its crops begin with it
    camera_m: float  #: height of the camera, relative to which the crops' windows are given
    placed: bool  #: whether its scale is the plan's
    step_m: float  #: height of the clearest step of colour; NaN for none
    #: upper, step: (3,) float: log of the linear RGB above the step, and of the ratio below / above
    upper: np.ndarray
    step: np.ndarray
    width_m: float  #: width along which the step is seen
    #: (n,) float: width that is seen both above and below each of `_HEIGHTS`, metres; 0 where that
    #: is too little
    widths: np.ndarray


@dataclass(frozen=True, eq=False)
class WallBands:
    """Two bands of the walls of a room.

    They part at `split_m` above the floor; `upper` and `lower` (3,) are linear RGB in the photos'
    light. `planes` are those of the room's walls, with the heights of their cameras.
    """

    split_m: float
    upper: np.ndarray
    lower: np.ndarray
    confidence: float
    photos: tuple[str, ...]
    planes: dict[str, float]


def wall_views(seen: PhotoPlanes) -> Iterator[WallView]:
    """Yield the walls of the photo's own room of which it shows a large enough part."""
    height, width = seen.image.shape[:2]
    scale = min(1.0, BANDS.photo_px / max(height, width))
    shape = max(1, round(height * scale)), max(1, round(width * scale))
    image = cv2.resize(seen.image, shape[::-1], interpolation=cv2.INTER_AREA)
    for camera, item in seen.planes:
        plane = item.plane
        if plane.surface != "wall" or len(item.rooms) != 1 or not item.own:
            continue
        mask = cv2.resize(plane.mask.astype(np.uint8), shape[::-1], interpolation=cv2.INTER_NEAREST)
        whole = rectify(image, camera.resized(shape), replace(plane, mask=mask > 0))
        if whole is None:
            continue
        straight, inside = whole.at_scale(BANDS.px_per_m)
        if min(inside.shape) < BANDS.least_m * BANDS.px_per_m / 2:
            continue
        name = f"wall/{PurePath(seen.photo).stem}_{plane.index}"
        top = plane.camera_height_m - whole.origin[1]
        height, upper, step, wide, widths = read_step(straight, inside, top)
        facts = seen.photo, item.rooms[0], name, plane.camera_height_m, item.in_plan
        yield WallView(*facts, height, upper, step, wide, widths)


def read_step(
    image: np.ndarray, mask: np.ndarray, top_m: float
) -> tuple[float, np.ndarray, np.ndarray, float, np.ndarray]:
    """Return the clearest step of a wall: `step_m` to `widths` of :class:`WallView`.

    `image` (h, w, 3) uint8 sRGB at `BANDS.px_per_m`, `mask` (h, w) bool; their top row is at height
    `top_m`.
    """
    logs = np.log(srgb_to_linear(image) + 0.01).astype(np.float32)
    # Masks leave out pixels near an edge. All pixels give its height, those of the mask confirm it.
    between = np.logical_or.accumulate(mask) & np.logical_or.accumulate(mask[::-1])[::-1]
    everything, sums = (_Strips(logs, part) for part in (between, mask))
    strip, gap = (round(m * BANDS.px_per_m) for m in (BANDS.strip_m, BANDS.gap_m))
    worth, widths = np.zeros((2, len(_HEIGHTS)))
    colours = np.zeros((len(worth), 2, 3))
    for k, height in enumerate(_HEIGHTS):
        row = round((top_m - height) * BANDS.px_per_m)
        above, below = (row - gap - strip, row - gap), (row + gap, row + gap + strip)
        if above[0] < 0 or below[1] > image.shape[0]:
            continue
        both = everything.known(*above) & everything.known(*below)
        both &= (sums.rows(0, above[1]) >= strip) & (sums.rows(below[0], len(image)) >= strip)
        if both.sum() * BANDS.column_m < BANDS.least_m:
            continue
        widths[k] = both.sum() * BANDS.column_m
        steps = (everything.mean(*below) - everything.mean(*above))[both]
        median_step = np.median(steps, axis=0)
        size = _size(median_step)
        # The whole wall above must differ from that below: else it is only a line or a shadow.
        whole = (sums.mean(row + gap, len(image)) - sums.mean(0, row - gap))[both]
        alike = (_shared(steps, median_step) > 0.5) & (_shared(whole, median_step) > 0.5)
        half = strip // 2
        within = [
            (everything.mean(first + half, last) - everything.mean(first, last - half))[both]
            for first, last in (above, below)
        ]
        fades = max(_size(np.median(part, axis=0)) for part in within)
        clear = size >= BANDS.step and alike.mean() >= BANDS.along
        if clear and size >= BANDS.sharp * fades:
            worth[k] = size * float(alike.mean())
            colours[k] = np.median(sums.mean(0, row - gap)[both], axis=0), median_step
    k = int(worth.argmax())
    if worth[k] <= 0.0:
        return float("nan"), np.zeros(3), np.zeros(3), 0.0, widths
    # The step is as clear wherever the edge lies within the gap: take the mean of these heights.
    near = slice(max(k - 2 * gap, 0), k + 2 * gap + 1)
    weight = np.where(worth[near] >= 0.9 * worth[k], worth[near], 0.0)
    height = float(np.average(_HEIGHTS[near], weights=weight))
    return height, *colours[k], float(widths[k]), widths


class _Strips:
    """Cumulative sums down an image (h, w, 3) over a mask (h, w), in columns of `column_m`."""

    def __init__(self, logs: np.ndarray, mask: np.ndarray) -> None:
        columns = max(1, round(mask.shape[1] / (BANDS.column_m * BANDS.px_per_m)))
        shape = (columns, mask.shape[0])
        weight = mask.astype(np.float32)
        count = cv2.resize(weight, shape, interpolation=cv2.INTER_AREA)
        total = cv2.resize(logs * weight[..., None], shape, interpolation=cv2.INTER_AREA)
        total = total.reshape(*count.shape, 3).astype(np.float64)
        self._total = np.pad(total.cumsum(axis=0), ((1, 0), (0, 0), (0, 0)))
        self._weight = np.pad(count.astype(np.float64).cumsum(axis=0), ((1, 0), (0, 0)))

    def rows(self, first: int, last: int) -> np.ndarray:
        """Return how many rows from `first` to before `last` each column (n,) shows."""
        return np.asarray(self._weight[last] - self._weight[first])

    def known(self, first: int, last: int) -> np.ndarray:
        """Return which columns (n,) show most of these rows."""
        return np.asarray(self.rows(first, last) >= 0.6 * (last - first))

    def mean(self, first: int, last: int) -> np.ndarray:
        """Return the mean colour (n, 3) of these rows in each column."""
        count = np.maximum(self.rows(first, last), 1e-6)
        return np.asarray((self._total[last] - self._total[first]) / count[:, None])


def _size(step: np.ndarray) -> float:
    """Return the size of a change of log colour (3,), with brightness counted half."""
    grey = float(step @ _GREY)
    return float(np.hypot(0.5 * grey, np.linalg.norm(step - grey)))


def _shared(steps: np.ndarray, usual: np.ndarray) -> np.ndarray:
    """Return the projection (n,) of steps (n, 3) on the usual step (3,): 1 for an equal step."""
    return np.asarray(steps @ usual / max(float(usual @ usual), 1e-9))


def find_bands(views: Sequence[WallView], wet: Collection[str] = ()) -> dict[str, WallBands]:
    """Return the bands of each room whose walls have any; in `wet` rooms they may part higher."""
    found = {}
    for room in sorted({view.room for view in views}):
        room_views = [view for view in views if view.room == room]
        if room not in wet:
            room_views = [
                replace(v, step_m=np.nan) if v.step_m > BANDS.dry_m else v for v in room_views
            ]
        bands = _agreed(room_views)
        if bands is not None:
            found[room] = bands
    return found


def _agreed(views: Sequence[WallView]) -> WallBands | None:
    """Return the bands on which most of a room's views (by width) agree; None if there are none."""
    stepped = [view for view in views if np.isfinite(view.step_m)]
    if not stepped:
        return None

    def near(middle: WallView) -> list[WallView]:
        close = [
            v
            for v in stepped
            if abs(np.log(v.step_m / middle.step_m))
            <= (BANDS.same if v.placed and middle.placed else BANDS.unplaced)
        ]
        return [v for v in close if _shared(v.step[None], middle.step)[0] > 0.5]

    together = max(
        (near(view) for view in stepped), key=lambda group: sum(v.width_m for v in group)
    )
    weights = np.array([view.width_m for view in together])
    split = _middle(np.array([view.step_m for view in together]), weights)
    away = np.abs(np.log(_HEIGHTS / split))
    others = [view for view in views if view not in together]
    other_width = sum(
        float(view.widths[away <= (away.min() if view.placed else BANDS.unplaced)].min())
        for view in others
    )
    share = float(weights.sum() / (weights.sum() + other_width))
    photos = tuple(sorted({view.photo for view in together}))
    if len(together) < BANDS.views or share < BANDS.most:
        return None
    upper, step = (
        np.exp(np.average([getattr(v, name) for v in together], axis=0, weights=weights))
        for name in ("upper", "step")
    )
    planes = {view.plane: view.camera_m for view in views}
    return WallBands(round(split, 3), upper, upper * step, share, photos, planes)


def _middle(values: np.ndarray, weights: np.ndarray) -> float:
    """Return the mean of positive values near their weighted median."""
    order = np.argsort(values)
    reached = np.cumsum(weights[order])
    median = values[order][np.searchsorted(reached, 0.5 * reached[-1])]
    near = np.abs(np.log(values / median)) <= BANDS.same
    return float(np.average(values[near], weights=weights[near]))
