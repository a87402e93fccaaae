"""Photos that show the same things, were taken from one spot, or look alike.

Matched points show the first two. Where the Manhattan frames of both photos are known, only the
number of quarter turns between them and the direction from one camera to the other are unknown.
Many matches that agree with one choice of both are no coincidence. Colours and features of whole
photos show the third.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np

from plan2scene.camera import Camera
from plan2scene.seeds import generator


@dataclass(frozen=True)
class MatchSettings:
    """Constants of the matching of photos. Source: set by hand on a listing (development)."""

    side_px: int = 400  #: longer side that photos are reduced to, pixels
    points: int = 400  #: largest number of points of a photo
    contrast: float = 0.02  #: least contrast of a point (OpenCV's SIFT)
    ratio: float = 0.8  #: largest distance of a match over that of the second best (Lowe 2004)
    apart_px: float = 6.0  #: matches that move less are dropped: they lie on a watermark, pixels
    least: int = 8  #: pairs of photos with fewer matches than this are skipped


@dataclass(frozen=True)
class SpotSettings:
    """Constants of :func:`same_spot`. Source: set by hand on a real flat (development).

    There 75 % and more of the matches of two photos from one spot have the same direction in both,
    and 20 % and less of the matches of other pairs.
    """

    agrees_deg: float = 3.0  #: largest angle between a point's directions in both photos, degrees
    share: float = 0.5  #: least share of the matches that agree so


@dataclass(frozen=True)
class TurnSettings:
    """Constants of :func:`same_things`, which finds how the frames of two photos are turned.

    Source: set by hand on two real flats and a listing (development). There the turn is right for
    all pairs that pass, and they show one room or rooms that are open to each other.
    """

    agrees_deg: float = 1.0  #: largest angle of the second ray to its epipolar plane, degrees
    ways: int = 300  #: directions from one camera to the other that are tried, each both ways
    #: Their largest rise, degrees: steeper ones make photos of one spot fit half a turn, too.
    rise_deg: float = 45.0
    #: Points nearer to such a direction than this say nothing about it, radians.
    ahead: float = 0.02
    least: int = 10  #: least number of matches that agree
    share: float = 0.5  #: least share of the matches that agree
    lead: float = 1.2  #: least ratio of the matches that agree to those of the second best turn


class SeenByBoth(NamedTuple):
    """Points that two photos show, as rays of length 1 in each photo's Manhattan frame."""

    pair: tuple[str, str]  #: the lesser name first
    ahead: np.ndarray  #: (n, 3), rays of the first photo
    seen: np.ndarray  #: (n, 3), rays of the second photo


MATCHES, SPOTS, TURNS = MatchSettings(), SpotSettings(), TurnSettings()


@dataclass(frozen=True, eq=False)
class Points:
    """SIFT points of a photo."""

    places: np.ndarray  #: (n, 2) float32, pixels of the reduced photo
    looks: np.ndarray  #: (n, 128) float32 descriptors of length 1
    zoom: float = 1.0  #: side of the reduced photo over the side of the photo


def find_points(image: np.ndarray) -> Points:
    """Return the SIFT points of a (h, w, 3) uint8 sRGB photo, the strongest first."""
    zoom = min(1.0, MATCHES.side_px / max(image.shape[:2]))
    small = cv2.resize(image, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_AREA)
    grey = cv2.createCLAHE(2.0, (8, 8)).apply(cv2.cvtColor(small, cv2.COLOR_RGB2GRAY))
    finder = cv2.SIFT.create(MATCHES.points, contrastThreshold=MATCHES.contrast)
    keypoints, looks = finder.detectAndCompute(grey, None)
    if not keypoints:
        return Points(np.zeros((0, 2), np.float32), np.zeros((0, 128), np.float32))
    order = np.argsort([-point.response for point in keypoints], kind="stable")[: MATCHES.points]
    roots = np.sqrt(looks / np.maximum(looks.sum(axis=1, keepdims=True), 1e-9))
    places = np.array([point.pt for point in keypoints], np.float32)
    return Points(places[order], roots[order].astype(np.float32), zoom)


def same_spot(seen_by_both: Sequence[SeenByBoth]) -> dict[tuple[str, str], int]:
    """Return the pairs of photos from one spot, the lesser name first, with their turn.

    The turn is in quarter turns, 0 to 3: by so much the azimuth of a thing in the first photo's
    Manhattan frame is larger than in the second photo's.
    """
    turn_of_pair = {}
    for pair, ahead, other_rays in seen_by_both:
        agree = [
            (np.sum(ahead * turned, axis=1) > np.cos(np.radians(SPOTS.agrees_deg))).sum()
            for turned in _quarter_turns(other_rays)
        ]
        quarters = int(np.argmax(agree))
        if agree[quarters] >= max(MATCHES.least, SPOTS.share * len(ahead)):
            turn_of_pair[pair] = quarters
    return turn_of_pair


def same_things(seen_by_both: Sequence[SeenByBoth]) -> dict[tuple[str, str], int]:
    """Return the pairs of photos that see the same things, with their turns as in `same_spot`.

    Enough matches of a pair must agree with one turn and one direction between the cameras.
    """
    turn_of_pair = {}
    for pair, ahead, other_rays in seen_by_both:
        rng = generator(0, "same things", *pair)
        starts = rng.integers(len(ahead), size=(TURNS.ways, 2))
        agree = [_moved(ahead, turned, starts) for turned in _quarter_turns(other_rays)]
        second, first = sorted(agree)[-2:]
        least = max(TURNS.least, TURNS.share * len(ahead), TURNS.lead * second)
        if first >= least:
            turn_of_pair[pair] = int(np.argmax(agree))
    return turn_of_pair


def _moved(ahead: np.ndarray, seen: np.ndarray, starts: np.ndarray) -> int:
    """Return how many pairs of rays (n, 3) from two cameras meet, for the best direction between.

    Each pair of points in `starts` (t, 2) gives a direction from the first camera to the second. It
    lies in the plane of each point's two rays, so it is the line where both planes cross (essential
    matrix of a known turn; Hartley and Zisserman 2004, 9.6).
    """
    normals = np.cross(ahead, seen)
    ways = np.cross(normals[starts[:, 0]], normals[starts[:, 1]])
    size = np.linalg.norm(ways, axis=1)
    ways = ways[size > 1e-6] / size[size > 1e-6, None]
    ways = ways[np.abs(ways[:, 1]) < np.sin(np.radians(TURNS.rise_deg))]
    if not len(ways):
        return 0
    ways = np.concatenate([ways, -ways])
    across = np.cross(ways[:, None], ahead[None])
    width = np.linalg.norm(across, axis=2)
    off = np.abs((across * seen).sum(axis=2)) / np.maximum(width, 1e-9)
    # The angle between a point's ray and the direction of motion grows as the camera moves.
    behind = seen @ ways.T <= ahead @ ways.T + 0.005
    meets = (off < np.sin(np.radians(TURNS.agrees_deg))) & behind.T & (width > TURNS.ahead)
    return int(meets.sum(axis=1).max())


def matched_rays(
    photos: Mapping[str, Points], cameras: Mapping[str, Camera]
) -> Iterator[SeenByBoth]:
    """Yield the pairs of photos that match; photos without a Manhattan frame are skipped."""
    rays = {
        name: cameras[name].rays((points.places + 0.5) / points.zoom - 0.5)
        for name, points in photos.items()
        if len(points.places) and not cameras[name].fallback
    }
    for one, other in itertools.combinations(sorted(rays), 2):
        here, there = _matches(photos[one], photos[other])
        if len(here) >= MATCHES.least:
            yield SeenByBoth((one, other), rays[one][here], rays[other][there])


def colours_of(image: np.ndarray) -> np.ndarray:
    """Return the square root of the colour histogram, (256,), of a (h, w, 3) uint8 sRGB photo."""
    zoom = min(1.0, MATCHES.side_px / max(image.shape[:2]))
    small = cv2.resize(image, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_AREA)
    lab = cv2.cvtColor(small, cv2.COLOR_RGB2LAB)
    lab[..., 1:] = np.clip(lab[..., 1:], 96, 159)  # few things in rooms have stronger colours
    counts = cv2.calcHist([lab], [0, 1, 2], None, [4, 8, 8], [0, 256, 96, 160, 96, 160])
    return np.asarray(np.sqrt(counts.ravel() / lab[..., 0].size))


def likeness(photos: Mapping[str, Sequence[np.ndarray]]) -> dict[tuple[str, str], float]:
    """Return the likeness of each pair of photos of a home, -1 to 1, the lesser name first.

    Each photo has the same kinds of vectors, each of any length. The home's mean is subtracted from
    each vector. The likeness is the cosine between two photos' vectors, averaged over the kinds.
    """
    names = sorted(photos)
    alike = np.zeros((len(names), len(names)))
    for vectors in zip(*(photos[name] for name in names), strict=True):
        own = np.stack(vectors).astype(np.float64)
        own -= own.mean(axis=0)
        own /= np.linalg.norm(own, axis=1, keepdims=True) + 1e-9
        alike += own @ own.T / len(photos[names[0]])
    pairs = itertools.combinations(range(len(names)), 2)
    return {(names[a], names[b]): float(alike[a, b]) for a, b in pairs}


def _quarter_turns(rays: np.ndarray) -> list[np.ndarray]:
    """Return rays (n, 3) with azimuths ``atan2(x, z)`` larger by 0 to 3 quarter turns."""
    x, y, z = rays.T
    return [np.stack(turned, axis=1) for turned in ((x, y, z), (z, y, -x), (-x, y, -z), (-z, y, x))]


def _matches(one: Points, other: Points) -> tuple[np.ndarray, np.ndarray]:
    """Return the indices (n,) of the points of two photos that match each other."""
    if min(len(one.looks), len(other.looks)) < MATCHES.least:
        return np.zeros(0, int), np.zeros(0, int)
    alike = one.looks @ other.looks.T
    best = alike.argmax(axis=1)
    rows = np.arange(len(best))
    first = alike[rows, best]
    mutual = alike.argmax(axis=0)[best] == rows
    alike[rows, best] = -1.0
    away, second = (np.sqrt(np.maximum(2 - 2 * a, 0)) for a in (first, alike.max(axis=1)))
    moved = np.linalg.norm(one.places - other.places[best], axis=1) > MATCHES.apart_px
    kept = np.flatnonzero(mutual & moved & (away < MATCHES.ratio * second))
    return kept, best[kept]
