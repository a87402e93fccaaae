"""Read pictures of plans, turn them straight, and refuse other pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from scipy import ndimage
from shapely.geometry import Polygon

from plan2scene.errors import InputError
from plan2scene.images import read_reduced_image
from plan2scene_app.pdf import is_pdf, page_picture, page_texts, pages_by_lines
from plan2scene_app.tracing.lettering import TextLine
from plan2scene_app.tracing.regions import Regions
from plan2scene_app.tracing.settings import DOOR, OUTSIDE, ROOM, SETTINGS
from plan2scene_app.tracing.sheet import Sheet, find_sheet, in_even_light
from plan2scene_app.tracing.tilt import find_tilt


@dataclass(frozen=True)
class PlanPicture:
    """A picture (h, w, 3) uint8 sRGB of a file, cut to what is drawn with little paper around it.

    A pixel of it is `shrunk` pixels of the file; `corner` (x, y) in the file is its upper left one.
    Where the picture shows a `sheet`, its pixels at the file's resolution stand for the file's.
    """

    image: np.ndarray
    shrunk: float
    corner: tuple[float, float] = (0.0, 0.0)
    sheet: Sheet | None = None  #: in pixels of the file
    file_size: tuple[int, int] = (0, 0)  #: height and width of the file, pixels
    texts: tuple[TextLine, ...] = ()  #: what a PDF holds as letters, in pixels of the picture

    def resized(self, zoom: float) -> PlanPicture:
        """Return the picture `zoom` times as large, at most 1."""
        if zoom >= 1:
            return self
        image = cv2.resize(self.image, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_AREA)
        texts = tuple(line.moved(zoom) for line in self.texts)
        return replace(self, image=image, shrunk=self.shrunk / zoom, texts=texts)


def read_plan_picture(path: str | Path, page: int | None = None) -> PlanPicture:
    """Return a picture of at most `long_side_px` a side; InputError if it is empty or too small.

    Of a PDF the `page` of this number, from 1, is read, or the one with the most lines.
    """
    side = SETTINGS.long_side_px
    if page is None and is_pdf(path):
        page = pages_by_lines(path)[0]
    image, (height, width) = read_reduced_image(path, side, page_of=page_picture(page))
    if min(height, width) < SETTINGS.least_side_px:
        expected = f"a plan of at least {SETTINGS.least_side_px} pixels a side"
        raise InputError(expected, f"{width}x{height}", file=path)
    reduced = max(height, width) / max(image.shape[:2])
    sheet = find_sheet(image)
    if sheet is None:
        even = in_even_light(image)
        sheet = None if even is image else find_tilt(image)
        image = image if sheet else even
    if sheet is not None:
        fine = min(1.0, 2 * SETTINGS.long_side_px / max(sheet.size))
        image = sheet.straightened(image, fine)
        sheet, reduced = sheet.enlarged(reduced), reduced / fine
    rows, columns = _printed(image)
    image = image[rows, columns]
    corner = columns.start * reduced, rows.start * reduced
    texts = () if sheet else _texts_of(path, page, corner, 1 / reduced)
    picture = PlanPicture(image, reduced, corner, sheet, (height, width), texts)
    picture = picture.resized(SETTINGS.long_side_px / max(image.shape[:2]))
    image = picture.image
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    low, high = np.percentile(cv2.blur(grey, (3, 3)), [0.2, 99.8])
    if high - low < SETTINGS.contrast:
        raise InputError("a picture of a floorplan", "an empty page", file=path)
    return picture


#: What is added to the width and height of letters in a PDF, over the smaller of them: their boxes
#: are tight, and a line's box holds all of its ink.
_MARGIN = 0.5


def _texts_of(
    path: str | Path, page: int | None, corner: tuple[float, float], zoom: float
) -> tuple[TextLine, ...]:
    """Return what a page of a PDF holds as letters, in pixels of its cut and resized picture."""
    lines = []
    for text, box in page_texts(path, page) if page else ():
        x, y = (0.5 * (box[:2] + box[2:])).tolist()
        width, height = (box[2:] - box[:2]).tolist()
        margin = _MARGIN * min(width, height)
        line = TextLine(text, (x, y), (width + margin, height + margin), 1.0)
        lines.append(line.moved(zoom, (-corner[0] * zoom, -corner[1] * zoom)))
    return tuple(lines)


def _printed(image: np.ndarray) -> tuple[slice, slice]:
    """Return the rows and columns that hold what is drawn, or all if it fills most of them."""
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    paper = round(float(np.percentile(grey, 90)))
    ink = np.where(grey > paper, grey - np.uint8(paper), np.uint8(paper) - grey)  # no copy as float
    left, top, width, height = cv2.boundingRect((ink > SETTINGS.drawing_ink).astype(np.uint8))
    printed = slice(top, top + height), slice(left, left + width)
    if not width or fills(printed, grey.shape):
        return slice(0, grey.shape[0]), slice(0, grey.shape[1])
    edge = round(SETTINGS.printed_edge * max(grey.shape))
    rows, columns = (slice(max(0, part.start - edge), part.stop + edge) for part in printed)
    return rows, columns


def dark_on_light(image: np.ndarray) -> np.ndarray:
    """Return a picture (h, w, 3) uint8 sRGB with dark lines: light lines on dark are inverted.

    A sheet photographed in a dim room is dark, too, but stays: its lines are darker than its paper.
    """
    grey = cv2.blur(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), (3, 3))
    low, paper, high = np.percentile(grey, [1, 50, 99])
    light = paper < SETTINGS.dark_page and high - paper > SETTINGS.light_lines * (paper - low)
    return np.asarray(255 - image) if light and flat_share(image) > SETTINGS.drawn_flat else image


def how_sure(probabilities: np.ndarray, regions: Regions) -> float:
    """Return the mean probability of the likeliest label over all rooms; 0 without rooms."""
    if not regions.count:
        return 0.0
    best = np.maximum(probabilities[:ROOM].max(0), probabilities[ROOM:].sum(0))
    return float(best[regions.rooms > 0].mean())


def refuse_other_pictures(
    path: str | Path,
    image: np.ndarray,
    sure: float,
    polygons: Mapping[int, Polygon],
    openings: int,
) -> None:
    """Raise InputError for a photo, a page of text or another picture without a plan.

    The network finds rooms in photos, too. But their probability is low, and a photo has few flat
    areas and no paper.
    """
    reason, busy = "", flat_share(image) < SETTINGS.busy
    if not polygons:
        reason = "no room that walls close"
    elif not openings:
        reason = "areas without any door or window"
    else:
        drawn = paper_share(image) >= SETTINGS.drawn_paper
        if busy and sure < SETTINGS.least_sure[0 if drawn else 1]:
            reason = f"areas that are rooms with a probability of {sure:.0%} only"
    if reason:
        if busy:
            reason = f"probably a photo ({reason})"
        raise InputError("a picture of a floorplan", reason, file=path)


def paper_share(image: np.ndarray) -> float:
    """Return the share of a picture (h, w, 3) uint8 sRGB that has its most frequent colour."""
    zoom = 384 / max(image.shape[:2])
    how = cv2.INTER_AREA if zoom < 1 else cv2.INTER_NEAREST
    small = cv2.resize(image, None, fx=zoom, fy=zoom, interpolation=how).astype(int)
    coarse = small // 4 @ [4096, 64, 1]
    paper = int(np.bincount(coarse.ravel()).argmax())
    colour = np.array([paper // 4096, paper // 64 % 64, paper % 64]) * 4 + 2
    return float((np.abs(small - colour).max(2) <= 6).mean())


def flat_share(image: np.ndarray) -> float:
    """Return the share of (h, w, 3) uint8 sRGB with hardly any gradient, at 384 pixels a side."""
    zoom = 384 / max(image.shape[:2])
    how = cv2.INTER_AREA if zoom < 1 else cv2.INTER_LINEAR
    small = cv2.medianBlur(cv2.resize(image, None, fx=zoom, fy=zoom, interpolation=how), 3)
    light = cv2.cvtColor(small, cv2.COLOR_RGB2LAB)[..., 0].astype(np.float32)
    slope = np.hypot(cv2.Sobel(light, cv2.CV_32F, 1, 0), cv2.Sobel(light, cv2.CV_32F, 0, 1)) / 8
    return float(np.mean(slope < 1))


@dataclass(frozen=True)
class Frame:
    """A straightened part of a picture; `matrix` (2, 3) maps the picture's pixels to its own."""

    image: np.ndarray  #: (h, w, 3) uint8
    matrix: np.ndarray

    @property
    def zoom(self) -> float:
        """Pixels of the frame for one of the picture."""
        return float(np.sqrt(abs(np.linalg.det(self.matrix[:, :2]))))

    def of_picture(self, points: np.ndarray) -> np.ndarray:
        """Return points (n, 2) of the picture in the frame."""
        return np.asarray(points @ self.matrix[:, :2].T + self.matrix[:, 2])

    def to_picture(self, points: np.ndarray) -> np.ndarray:
        """Return points (n, 2) of the frame in the picture."""
        return np.asarray((points - self.matrix[:, 2]) @ np.linalg.inv(self.matrix[:, :2]).T)


def fills(part: tuple[slice, slice], shape: tuple[int, ...]) -> bool:
    """Return whether rows and columns fill most of a picture, so that nothing is cut off it."""
    longer = max(box.stop - box.start for box in part)
    return longer >= SETTINGS.fills * max(shape[:2])


def whole(image: np.ndarray, long_side: int) -> Frame:
    """Return a whole picture with its longer side at `long_side` pixels."""
    zoom = long_side / max(image.shape[:2])
    how = cv2.INTER_AREA if zoom < 1 else cv2.INTER_CUBIC
    small = cv2.resize(image, None, fx=zoom, fy=zoom, interpolation=how)
    return Frame(small, np.array([[zoom, 0, 0], [0, zoom, 0]], float))


def main_direction(walls: np.ndarray) -> float:
    """Return the degrees, -45 to 45, by which walls (h, w; probabilities) are turned clockwise."""
    smooth = cv2.GaussianBlur(walls.astype(np.float32), (0, 0), 1.2)
    gx, gy = cv2.Sobel(smooth, cv2.CV_32F, 1, 0), cv2.Sobel(smooth, cv2.CV_32F, 0, 1)
    strength = gx**2 + gy**2
    angles = np.degrees(np.arctan2(gy, gx)) % 90
    counts, edges = np.histogram(angles, bins=360, range=(0, 90), weights=strength)
    kernel = np.exp(-0.5 * (np.arange(-12, 13) / 4) ** 2)
    padded = np.concatenate([counts[-12:], counts, counts[:12]])
    peak = edges[int(np.convolve(padded, kernel, "valid").argmax())]
    off = (angles - peak + 45) % 90 - 45
    near = np.abs(off) < 3
    total = float(strength[near].sum())
    angle = peak + (float((off * strength)[near].sum()) / total if total else 0.0)
    return float((angle + 45) % 90 - 45)


def first_scale(structure: np.ndarray) -> float:
    """Estimate the pixels a metre of a structure (h, w) from its doors and its size."""
    return scale_by_doors(door_widths(structure), drawn_size(structure))


def door_widths(structure: np.ndarray) -> list[int]:
    """Return the widths in pixels of the doors of a structure (h, w)."""
    places, count = ndimage.label(structure == DOOR, np.ones((3, 3)))
    widths = [max(b.stop - b.start for b in box) for box in ndimage.find_objects(places, count)]
    return [width for width in widths if width >= 6]


def drawn_size(structure: np.ndarray) -> float:
    """Return the longer side in pixels of the plan in a structure (h, w)."""
    rows, columns = np.nonzero(_largest_part(structure != OUTSIDE))
    return max(float(np.ptp(rows)), float(np.ptp(columns)), 1.0) if len(rows) else 1.0


def scale_by_doors(widths: Sequence[float], size: float) -> float:
    """Estimate the pixels a metre from the doors' widths and the plan's longer side, in pixels."""
    size_log, spread = np.log(size / SETTINGS.home_size[0]), SETTINGS.home_size[1]
    if not widths:
        return float(np.exp(size_log))
    # The 70th percentile, as half of a door is found more often than two doors as one.
    door_log, unsure = (
        np.log(np.percentile(widths, 70) / SETTINGS.door_width[0]),
        0.15 + 0.4 / len(widths),
    )
    weights = np.array([1 / spread**2, 1 / unsure**2])
    return float(np.exp((weights * [size_log, door_log]).sum() / weights.sum()))


def outline_of(first: Frame, structure: np.ndarray) -> np.ndarray:
    """Return the plan's points (n, 2) in the picture: walls, openings and rooms of `first`."""
    rows, columns = np.nonzero(_largest_part(structure != OUTSIDE))
    return first.to_picture(np.c_[columns, rows].astype(float))


def straightened(
    image: np.ndarray,
    outlines: Sequence[np.ndarray],
    ppm: float,
    angle: float,
    *,
    beyond: np.ndarray,
) -> tuple[Frame, list[tuple[slice, slice]]]:
    """Return a straight frame at the network's size, and the place of each drawing in it.

    `outlines` are points (n, 2) of each drawing in the picture. `beyond` are further points (n, 2)
    that the frame must hold. `ppm` is the picture's pixels a metre, `angle` its turn in degrees.
    """
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    turn = np.array([[c, s], [-s, c]]) if abs(angle) >= SETTINGS.least_turn else np.eye(2)
    corners, paper = [], SETTINGS.paper * ppm
    for points in outlines:
        turned = points @ turn.T
        corners.append((turned.min(0) - paper, turned.max(0) + paper))
    more = beyond @ turn.T
    low = np.min([corner[0] for corner in corners] + [p - paper for p in more], axis=0)
    high = np.max([corner[1] for corner in corners] + [p + paper for p in more], axis=0)
    largest = max(float((b - a).max()) for a, b in corners)
    zoom = min(SETTINGS.ppm / ppm, SETTINGS.largest_px / largest, 3.0)
    frame = warped(image, turn, low, high, zoom)
    places = []
    for one, other in corners:
        x0, y0 = np.floor((one - low) * zoom).astype(int).tolist()
        x1, y1 = np.ceil((other - low) * zoom).astype(int).tolist()
        places.append((slice(y0, max(y1, y0 + 32)), slice(x0, max(x1, x0 + 32))))
    return frame, places


def warped(
    image: np.ndarray, turn: np.ndarray, low: np.ndarray, high: np.ndarray, zoom: float
) -> Frame:
    """Return the frame between two corners of the turned picture, `zoom` times as large."""
    size = np.maximum(32, np.ceil((high - low) * zoom)).astype(int)
    how = cv2.INTER_AREA if zoom < 1 else cv2.INTER_CUBIC
    small = cv2.resize(image, None, fx=zoom, fy=zoom, interpolation=how)
    matrix = np.c_[turn, -low * zoom]
    paper = np.median(np.r_[image[0], image[-1], image[:, 0], image[:, -1]], axis=0)
    warped_image = cv2.warpAffine(
        small,
        matrix,
        (int(size[0]), int(size[1])),
        flags=cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=[float(v) for v in paper],
    )
    return Frame(warped_image, np.c_[turn * zoom, -low * zoom])


def _largest_part(drawn: np.ndarray) -> np.ndarray:
    """Return the pixels without parts much smaller than the largest one (letters, stains)."""
    places, count = ndimage.label(drawn, np.ones((3, 3)))
    if count < 2:
        return drawn
    sizes = np.bincount(places.ravel())[1:]
    kept = np.flatnonzero(sizes >= 0.12 * sizes.max()) + 1
    return np.isin(places, kept)
