"""Walls in bands: of another colour up to some height, all around their room.

Tiles, panels and paint end at a height; light fades, and seldom changes its colour. So bands are
believed where the colour steps at one height along most of a wall, and where several views of the
room's walls agree on it.
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

    photo_px: int = 900  #: longer side that a photo is reduced to
    px_per_m: float = 40.0  #: of the walls that are read
    column_m: float = 0.1  #: width of the columns whose colours are compared
    strip_m: float = 0.16  #: height of what is compared above and below a step
    gap_m: float = 0.04  #: left out between them, on either side of the step
    heights_m: tuple[float, float] = (0.45, 2.1)  #: of a step above the floor
    #: Dados and low panels end below this; tiles of baths may reach up to a door's head.
    dry_m: float = 1.6
    least_m: float = 0.8  #: width that shows it in a view
    step: float = 0.25  #: change of log colour, that of brightness counted half
    along: float = 0.75  #: share of the columns whose step is like the usual one
    sharp: float = 2.5  #: times the change within the strips, that a step is at least
    same: float = 0.12  #: log ratio by which heights in located photos of a room may differ
    unplaced: float = 0.35  #: the same of other photos, whose camera is taken to be 1.5 m high
    views: int = 2  #: that have to show it: of one wall in several photos, or of several walls
    most: float = 0.6  #: share of the width seen at its height that has to show it


BANDS = BandSettings()
_GREY = np.full(3, 1 / 3)


@dataclass(frozen=True, eq=False)
class WallView:
    """A wall in one photo, seen straight on."""

    photo: str
    room: str
    plane: str  #: name of the plane, as the ids of its crops begin
    camera_m: float  #: height of the camera, to which the crops' windows refer
    placed: bool  #: whether its metres are the plan's
    step_m: float  #: height of the clearest step of colour; NaN for none
    #: upper, step: (3,) float: Log of the linear RGB above it, and of that below it over that above
    upper: np.ndarray
    step: np.ndarray
    width_m: float  #: width along which it is seen
    #: (n,) float: Width that is seen at and beside each height of `heights`, metres; 0 where it is
    #: too little
    widths: np.ndarray


@dataclass(frozen=True, eq=False)
class WallBands:
    """Two bands of the walls of a room.

    `split_m` above the floor; `upper` and `lower` (3,) linear RGB in the photos' light; `planes` of
    the room's walls with the height of their camera.
    """

    split_m: float
    upper: np.ndarray
    lower: np.ndarray
    confidence: float
    photos: tuple[str, ...]
    planes: dict[str, float]


def heights() -> np.ndarray:
    """Return the heights at which steps are looked for, metres."""
    return np.arange(*BANDS.heights_m, 1 / BANDS.px_per_m)


def wall_views(seen: PhotoPlanes) -> Iterator[WallView]:
    """Yield the walls of known rooms that a photo shows largely enough."""
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
        times = whole.metres_per_pixel * BANDS.px_per_m
        size = tuple(max(1, round(side * times)) for side in whole.mask.shape[::-1])
        if min(size) < BANDS.least_m * BANDS.px_per_m / 2:
            continue
        straight = cv2.resize(whole.image, size, interpolation=cv2.INTER_AREA)
        inside = cv2.resize(whole.mask.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST)
        name = f"wall/{PurePath(seen.photo).stem}_{plane.index}"
        top = plane.camera_height_m - whole.origin[1]
        height, upper, step, wide, widths = read_step(straight, inside > 0, top)
        facts = seen.photo, item.rooms[0], name, plane.camera_height_m, item.in_plan
        yield WallView(*facts, height, upper, step, wide, widths)


def read_step(
    image: np.ndarray, mask: np.ndarray, top_m: float
) -> tuple[float, np.ndarray, np.ndarray, float, np.ndarray]:
    """Return the clearest step of a wall: as of :class:`WallView`.

    `image` (h, w, 3) uint8 sRGB at `BANDS.px_per_m`, `mask` (h, w) bool, whose top row is at
    height `top_m`.
    """
    logs = np.log(srgb_to_linear(image) + 0.01).astype(np.float32)
    # Masks leave out what is near an edge: all pixels tell where it is, those of the wall whether.
    between = np.logical_or.accumulate(mask) & np.logical_or.accumulate(mask[::-1])[::-1]
    everything, sums = (_Strips.of(logs, part) for part in (between, mask))
    strip, gap = (round(m * BANDS.px_per_m) for m in (BANDS.strip_m, BANDS.gap_m))
    worth = np.zeros(len(heights()))
    colours = np.zeros((len(worth), 2, 3))
    widths = np.zeros(len(worth))
    for k, height in enumerate(heights()):
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
        usual = np.median(steps, axis=0)
        size = _size(usual)
        # What is above differs from what is below on the whole: no line, no shadow.
        whole = (sums.mean(row + gap, len(image)) - sums.mean(0, row - gap))[both]
        alike = (_shared(steps, usual) > 0.5) & (_shared(whole, usual) > 0.5)
        half = strip // 2
        within = [
            (everything.mean(first + half, last) - everything.mean(first, last - half))[both]
            for first, last in (above, below)
        ]
        fades = max(_size(np.median(part, axis=0)) for part in within)
        clear = size >= BANDS.step and alike.mean() >= BANDS.along
        if clear and size >= BANDS.sharp * fades:
            worth[k] = size * float(alike.mean())
            colours[k] = np.median(sums.mean(0, row - gap)[both], axis=0), usual
    k = int(worth.argmax())
    if worth[k] <= 0.0:
        return float("nan"), np.zeros(3), np.zeros(3), 0.0, widths
    # As clear wherever the edge lies within the gap.
    near = slice(max(k - 2 * gap, 0), k + 2 * gap + 1)
    weight = np.where(worth[near] >= 0.9 * worth[k], worth[near], 0.0)
    height = float(np.average(heights()[near], weights=weight))
    return height, *colours[k], float(widths[k]), widths


class _Strips:
    """Sums down the columns of an image (h, n, 3) whose pixels count by `weight` (h, n)."""

    def __init__(self, total: np.ndarray, weight: np.ndarray) -> None:
        self._total = np.pad(total.astype(np.float64).cumsum(axis=0), ((1, 0), (0, 0), (0, 0)))
        self._weight = np.pad(weight.astype(np.float64).cumsum(axis=0), ((1, 0), (0, 0)))

    @classmethod
    def of(cls, logs: np.ndarray, mask: np.ndarray) -> _Strips:
        """Return the sums of the pixels (h, w, 3) of a mask (h, w) bool, in columns of a width."""
        columns = max(1, round(mask.shape[1] / (BANDS.column_m * BANDS.px_per_m)))
        shape = (columns, mask.shape[0])
        weight = mask.astype(np.float32)
        count = cv2.resize(weight, shape, interpolation=cv2.INTER_AREA)
        total = cv2.resize(logs * weight[..., None], shape, interpolation=cv2.INTER_AREA)
        return cls(total.reshape(*count.shape, 3), count)

    def rows(self, first: int, last: int) -> np.ndarray:
        """Return how many of the rows each column (n,) shows."""
        return np.asarray(self._weight[last] - self._weight[first])

    def known(self, first: int, last: int) -> np.ndarray:
        """Return which columns (n,) show most of the rows."""
        return np.asarray(self.rows(first, last) >= 0.6 * (last - first))

    def mean(self, first: int, last: int) -> np.ndarray:
        """Return the mean (n, 3) of the rows."""
        count = np.maximum(self._weight[last] - self._weight[first], 1e-6)
        return np.asarray((self._total[last] - self._total[first]) / count[:, None])


def _size(step: np.ndarray) -> float:
    """Return how large a change of log colour (3,) is, that of brightness counted half."""
    grey = float(step @ _GREY)
    return float(np.hypot(0.5 * grey, np.linalg.norm(step - grey)))


def _shared(steps: np.ndarray, usual: np.ndarray) -> np.ndarray:
    """Return how much of the usual step (3,) is in each of others (n, 3)."""
    return np.asarray(steps @ usual / max(float(usual @ usual), 1e-9))


def find_bands(views: Sequence[WallView], wet: Collection[str] = ()) -> dict[str, WallBands]:
    """Return the rooms whose walls are in bands; those of `wet` rooms may part higher up."""
    found = {}
    for room in sorted({view.room for view in views}):
        mine = [view for view in views if view.room == room]
        if room not in wet:
            mine = [replace(v, step_m=np.nan) if v.step_m > BANDS.dry_m else v for v in mine]
        bands = _agreed(mine)
        if bands is not None:
            found[room] = bands
    return found


def _agreed(views: Sequence[WallView]) -> WallBands | None:
    """Return the bands that most views of a room's walls show, None for none."""
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
    away = np.abs(np.log(heights() / split))
    others = [view for view in views if view not in together]
    seen = sum(
        float(view.widths[away <= (away.min() if view.placed else BANDS.unplaced)].min())
        for view in others
    )
    share = float(weights.sum() / (weights.sum() + seen))
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
