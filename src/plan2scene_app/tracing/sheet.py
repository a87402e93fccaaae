"""Find the sheet of paper, or the window of a screenshot, that a picture of a plan shows.

A photo of a printed plan shows the table around it, opposite edges of the sheet are not parallel,
and the light varies. A screenshot has dark bars around the plan. All this is undone before the plan
is read.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from scipy import ndimage


@dataclass(frozen=True)
class SheetSettings:
    """Constants of sheets and their light. Source: set by hand on changed copies of four plans."""

    side_px: int = 640  #: longer side that the picture is reduced to
    least_area: float = 0.25  #: least share of the picture that the sheet covers
    around: float = 0.04  #: least share of the picture around it: less is a frame line
    fits: float = 0.96  #: least overlap (IoU) of the bright area, without its holes, and a quad
    #: Largest share of what is around it that is as bright: more is a second panel on a page.
    others: float = 0.15
    darker: float = 40.0  #: least difference in grey value between the sheet and what is around it
    blank: float = 0.6  #: least share of it that is bright: less are light walls on a dark page
    edge: float = 0.03  #: width of the sheet's margin, share of its shorter side, ...
    bare: float = 0.85  #: ... and least share of it that is bright: little is drawn there
    longest: float = 5.0  #: largest ratio of its sides
    inset: float = 0.006  #: what is cut off at each edge, share of the sheet: its shadow
    blocks: int = 24  #: rows and columns of blocks in which the light on the paper is measured
    paper: float = 90.0  #: percentile of a block's pixels that is bare paper
    unlike: float = 0.08  #: blocks this much darker than the light (logarithm) are drawn on
    #: A page is photographed in uneven light if that varies by at least `uneven` (logarithm), at
    #: least the share `paged` of its blocks is bare paper, and this is off by at most `smooth`.
    uneven: float = 0.1
    paged: float = 0.8
    smooth: float = 0.03
    contrast: float = 1.5  #: power of the brightness over paper's: blurred thin lines are pale
    #: Focal length of a phone over the photo's longer side, where the edges do not tell it; and
    #: the range in which it is believed.
    focal: float = 0.75
    focals: tuple[float, float] = (0.5, 1.5)


SHEET = SheetSettings()


@dataclass(frozen=True)
class Sheet:
    """The corners of a sheet in a picture, and the size that it has when seen from above."""

    #: (4, 2) float64, pixels (x, y): upper left, upper right, lower right, lower left
    corners: np.ndarray
    size: tuple[int, int]  #: width and height, pixels

    @property
    def to_picture(self) -> np.ndarray:
        """Return the homography (3, 3) from pixels of the straightened sheet to the picture's."""
        width, height = self.size
        own = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float32)
        return np.asarray(cv2.getPerspectiveTransform(own, self.corners.astype(np.float32)))

    def straightened(self, image: np.ndarray, zoom: float = 1.0) -> np.ndarray:
        """Return the sheet (h, w, 3) uint8 as seen from above in even light, its paper white.

        It is `zoom` times as large as `size`.
        """
        width, height = (max(1, round(zoom * side)) for side in self.size)
        own = np.diag([self.size[0] / width, self.size[1] / height, 1.0])
        seen = cv2.warpPerspective(
            image,
            self.to_picture @ own,
            (width, height),
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REPLICATE,
        )
        return _whitened(seen, _paper(seen))

    def enlarged(self, zoom: float) -> Sheet:
        """Return the sheet in a copy of the picture that is `zoom` times as large."""
        width, height = self.size
        corners = (self.corners + 0.5) * zoom - 0.5
        return Sheet(corners, (round(width * zoom), round(height * zoom)))


def find_sheet(image: np.ndarray) -> Sheet | None:
    """Return the bright sheet in a picture (h, w, 3) uint8 sRGB; None if there is none.

    It is a bright area with four straight edges and a bare margin, and what is around it is darker.
    """
    zoom = min(1.0, SHEET.side_px / max(image.shape[:2]))
    small = cv2.resize(image, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_AREA)
    grey = cv2.GaussianBlur(cv2.cvtColor(small, cv2.COLOR_RGB2GRAY), (0, 0), 1.0)
    _, bright = cv2.threshold(grey, 0, 1, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    parts, count = ndimage.label(bright)
    if not count:
        return None
    largest = int(np.bincount(parts.ravel())[1:].argmax()) + 1
    area = ndimage.binary_fill_holes(parts == largest)
    quad = _quad(area)
    if quad is None:
        return None
    inside = cv2.fillConvexPoly(np.zeros(grey.shape, np.uint8), np.rint(quad).astype(int), 1) > 0
    overlap = (inside & area).sum() / max((inside | area).sum(), 1)
    if not SHEET.least_area <= inside.mean() <= 1.0 - SHEET.around or overlap < SHEET.fits:
        return None
    width = max(2, round(SHEET.edge * _sides(quad).min()))
    depth = cv2.distanceTransform(np.pad(inside, 1).astype(np.uint8), cv2.DIST_L2, 5)[1:-1, 1:-1]
    margin = inside & (depth > 2) & (depth <= 2 + width)
    around = ~inside & (ndimage.distance_transform_edt(~inside) > 2)
    if not margin.any() or not around.any():
        return None
    darker = float(np.median(grey[margin]) - np.median(grey[around]))
    blank, bare, others = (bright[part].mean() for part in (inside, margin, around))
    if darker < SHEET.darker or blank < SHEET.blank or bare < SHEET.bare or others > SHEET.others:
        return None
    middle = quad.mean(axis=0)
    corners = (middle + (quad - middle) * (1.0 - 2.0 * SHEET.inset) + 0.5) / zoom - 0.5
    across, down = _sides(corners).reshape(2, 2).T.max(axis=1)
    ratio = _width_over_height(corners, image.shape[:2])
    if not 1.0 / SHEET.longest < ratio < SHEET.longest:
        return None
    height = max(down, across / ratio)
    return Sheet(corners, (round(height * ratio), round(height)))


@dataclass(frozen=True)
class _Paper:
    """The light on a page."""

    weights: np.ndarray  #: (6, 3) of :func:`_terms`: log of bare paper's colour, 0..255
    bare: float  #: share of the page's blocks that hold bare paper
    off: float  #: mean difference of these from the colour, logarithm
    range: float  #: by how much the colour varies over the page, logarithm


def _paper(page: np.ndarray) -> _Paper:
    """Return the light on a page (h, w, 3) uint8.

    It is a smooth function of the place: a polynomial of second order in the logarithm.
    """
    height, width = page.shape[:2]
    rows, columns = (np.linspace(0, side, SHEET.blocks + 1).astype(int) for side in (height, width))
    log, place = [], []
    for k in range(SHEET.blocks):
        for m in range(SHEET.blocks):
            block = page[rows[k] : rows[k + 1], columns[m] : columns[m + 1]].reshape(-1, 3)
            if len(block):
                log.append(np.log(np.maximum(np.percentile(block, SHEET.paper, axis=0), 1.0)))
                place.append(((k + 0.5) / SHEET.blocks, (m + 0.5) / SHEET.blocks))
    values, terms = np.array(log), _terms(*np.array(place).T)
    bare = np.ones(len(values), bool)
    for _ in range(5):
        weights = np.linalg.lstsq(terms[bare], values[bare], rcond=None)[0]
        bare = ((terms @ weights - values) < SHEET.unlike).all(axis=1)
    light = terms @ weights
    off = np.abs(light - values)[bare].mean() if bare.any() else np.inf
    return _Paper(weights, float(bare.mean()), float(off), float(np.ptp(light.mean(axis=1))))


def in_even_light(page: np.ndarray) -> np.ndarray:
    """Return a page (h, w, 3) uint8 of bare paper in uneven light as white paper.

    Any other picture is returned as it is.
    """
    paper = _paper(page)
    if paper.range < SHEET.uneven or paper.bare < SHEET.paged or paper.off > SHEET.smooth:
        return page
    return _whitened(page, paper)


def _whitened(page: np.ndarray, paper: _Paper) -> np.ndarray:
    y, x = ((np.arange(side) + 0.5) / side for side in page.shape[:2])
    white = np.empty_like(page)
    for row in range(len(page)):  # one by one, to save memory
        colour = np.exp(_terms(np.full_like(x, y[row]), x) @ paper.weights)
        bright = (page[row] / colour) ** SHEET.contrast
        white[row] = np.clip(255.0 * bright, 0.0, 255.0)
    return white


def _terms(y: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return the terms (..., 6) of a polynomial of second order."""
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)


def _quad(area: np.ndarray) -> np.ndarray | None:
    """Return the corners (4, 2) of a filled area (h, w) bool, clockwise from the upper left one."""
    outlines, _ = cv2.findContours(area.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    outline = max(outlines, key=len)
    hull = cv2.convexHull(outline)
    around = cv2.arcLength(hull, closed=True)
    for share in (0.01, 0.02, 0.03, 0.05):
        rough = cv2.approxPolyDP(hull, share * around, closed=True)[:, 0].astype(float)
        if len(rough) == 4:
            break
    else:
        return None
    points = outline[:, 0].astype(float)
    lines = []
    for a, b in zip(rough, np.roll(rough, -1, axis=0), strict=True):
        along = (b - a) / np.linalg.norm(b - a)
        place, off = (points - a) @ along, np.abs((points - a) @ [-along[1], along[0]])
        length = np.linalg.norm(b - a)
        near = points[(off < 0.02 * length) & (place > 0.05 * length) & (place < 0.95 * length)]
        if len(near) < 8:
            return None
        dx, dy, x, y = cv2.fitLine(near.astype(np.float32), cv2.DIST_HUBER, 0, 0.01, 0.01).ravel()
        lines.append(np.cross([x, y, 1.0], [x + dx, y + dy, 1.0]))
    corners = np.array([np.cross(lines[k - 1], lines[k]) for k in range(4)])
    if (np.abs(corners[:, 2]) < 1e-9).any():
        return None
    quad = corners[:, :2] / corners[:, 2:]
    order = np.argsort(np.arctan2(*(quad - quad.mean(axis=0)).T[::-1]))
    return np.asarray(quad[order])


def _sides(quad: np.ndarray) -> np.ndarray:
    """Return the lengths (4,) of a quad's sides: upper, right, lower, left."""
    return np.asarray(np.linalg.norm(np.roll(quad, -1, axis=0) - quad, axis=1))


def _width_over_height(corners: np.ndarray, shape: tuple[int, int]) -> float:
    """Return the width over the height of a rectangle from its corners (4, 2) in a photo.

    Zhang, He: Whiteboard scanning and image enhancement (2007, doi:10.1016/j.dsp.2006.05.006); the
    photo is not cropped, so that its optical axis is in the middle.
    """
    height, width = shape
    longer = max(shape)
    own = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
    seen = ((corners - [(width - 1) / 2, (height - 1) / 2]) / longer).astype(np.float32)
    move = cv2.getPerspectiveTransform(own, seen)
    across, down = move[:, 0], move[:, 1]
    vanish = across[2] * down[2]
    focal = SHEET.focal
    if abs(vanish) > 1e-3:
        square = -(across[:2] @ down[:2]) / vanish
        if SHEET.focals[0] ** 2 < square < SHEET.focals[1] ** 2:
            focal = float(np.sqrt(square))
    lengths = [np.linalg.norm([v[0] / focal, v[1] / focal, v[2]]) for v in (across, down)]
    return float(lengths[0] / lengths[1])
