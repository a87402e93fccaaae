"""Walls of a photo in plan view: which wall a viewing direction meets.

In the Manhattan frame nearly every wall is x = +-d or z = +-d (d metres from the camera); a bay
window's or a slanted one has a normal of its own where its foot shows it. The foot of a
wall, where wall pixels stand on floor pixels, lies on the floor plane, so its slope below the
horizon gives the distance; its top under the ceiling likewise. Viewing directions are binned by
azimuth (not by image column: with a pitched camera a vertical crease is no column), and the
cheapest sequence of walls over the bins is found by dynamic programming.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from plan2scene.camera import Camera
from plan2scene.photos.planes.beyond import room_reach
from plan2scene.photos.planes.room_size import RoomSize, extent_misfit, wall_spans
from plan2scene.photos.planes.wall_borders import N_BINS, Borders, facing_votes, find_borders
from plan2scene.photos.planes.wall_lines import (
    DISTANCE_RANGE_M,
    MIN_FACING,
    OWN,
    UNSEEN_LINES,
    WallLine,
    likely_walls,
)

#: Angular noise of a mask's border (radians), and the cost at which a point is an outlier.
BORDER_NOISE = np.radians(0.5)
OUTLIER = 9.0
#: How far wall pixels may reach beyond a wall's foot or top, radians.
BEYOND_NOISE = np.radians(1.5)
#: Cost of a corner, of a jump between parallel walls, and of a wall that no foot or top supports
#: (per bin).
CREASE = 14.0
JUMP = 28.0
UNSEEN = 0.4
#: Further cost of a crease with a wall that faces neither Manhattan direction.
SLANT = 16.0
#: Bins on both sides of a crease that must show something for it to be believed.
CREASE_BINS = 6
#: Cost per bin of each segment that runs along the other kind of wall, and its bound.
VOTE = 0.5
MAX_VOTES = 1.5
#: Heights of a camera that are believed, the spread of its prior, and the bins that give one.
HEIGHT_RANGE_M = (0.8, 2.1)
HEIGHT_SPREAD_M = 0.25
MIN_BINS = 8
#: Height above the camera of walls whose top is not asked, metres.
TALL_M = 10.0


@dataclass(frozen=True)
class TracedWalls:
    """Walls of a photo and the wall of each pixel."""

    #: The walls, in the order of `owner`.
    lines: list[WallLine]
    #: (h, w) int16: Index into `lines` of the wall that a pixel's azimuth meets; -1 for none.
    owner: np.ndarray
    #: (h, w) float64: How far the room reaches at a pixel's azimuth, metres; inf where not known.
    reach: np.ndarray
    #: (h, w) bool: Pixels whose azimuth looks through a door, at another room's walls.
    through: np.ndarray
    #: Height of the camera above the floor, metres.
    camera_height_m: float
    #: What gave it: ``room_height``, ``room_extent`` or ``camera_height`` (the prior).
    scale_source: str


def trace_walls(
    labels: np.ndarray,
    camera: Camera,
    camera_height_m: float,
    room: RoomSize,
    *,
    solve_height: bool,
    segments: np.ndarray | None = None,
) -> TracedWalls:
    """Return the walls that a label mask shows; parameters as in `planes.split_planes`.

    `solve_height` tells whether the room's height is known and may give the camera's.
    `segments` (s, 4), pixels, are line segments of the photo: horizontal ones on a wall tell
    which way it faces where neither its foot nor its top is seen.
    """
    borders = find_borders(labels, camera)
    facing = facing_votes(segments, labels, camera, borders.bins)
    height, source = camera_height_m, "camera_height"
    found = _camera_height(borders, facing, height, room.height_m) if solve_height else None
    if found is not None:
        height, source = found, "room_height"
    elif (fitting := _height_by_extent(borders, facing, height, room)) is not None:
        height, source = fitting, "room_extent"
    lines, path, _ = _solve(borders, facing, height, room.height_m - height)
    blind = np.isnan(borders.foot) & np.isnan(borders.top) & (facing.sum(axis=1) == 0.0)
    path = _settle_creases(path, lines, borders, blind)
    lines = _joined(path, lines, borders, blind)
    path = np.where(np.isnan(borders.reach[:, 0]), -1, path)
    used = sorted(set(path[path >= 0].tolist()))
    rank = np.full(len(lines) + 1, -1)
    rank[used] = np.arange(len(used))
    path = rank[path]
    traced = [lines[index] for index in used]
    reach, through = (part[borders.bins] for part in room_reach(traced, path, borders.direction))
    owner = path[borders.bins].astype(np.int16)
    return TracedWalls(traced, owner, reach, through, height, source)


def _camera_height(
    borders: Borders, facing: np.ndarray, prior: float, room_height_m: float
) -> float | None:
    """Return the camera's height from feet and tops of walls; None when too few are seen.

    The height at which feet and tops agree best on common walls; directions that show both
    then tell it exactly.
    """
    low, high = HEIGHT_RANGE_M[0], min(HEIGHT_RANGE_M[1], 0.9 * room_height_m)
    if high <= low:
        return None
    if min(np.isfinite(borders.foot).sum(), np.isfinite(borders.top).sum()) < MIN_BINS:
        return None

    def cost(height: float) -> float:
        unlikely = 2.0 * ((height - prior) / HEIGHT_SPREAD_M) ** 2
        return _solve(borders, facing, height, room_height_m - height)[2] + unlikely

    best = min(np.arange(low, high, 0.1).tolist(), key=cost)
    each = room_height_m / (1.0 + borders.top / -borders.foot)
    each = each[np.abs(each - best) < 0.15]
    if len(each) >= MIN_BINS:
        return float(np.clip(np.median(each), low, high))
    finer = np.arange(max(low, best - 0.08), min(high, best + 0.09), 0.02)
    return float(min(finer.tolist(), key=cost))


def _height_by_extent(
    borders: Borders, facing: np.ndarray, prior: float, room: RoomSize
) -> float | None:
    """Return the camera's height at which walls fit the room's extent; None if any height does.

    Only feet are asked: distances by them grow in proportion to the camera's height.
    """
    if room.extent_m is None:
        return None
    feet = replace(borders, top=np.full(N_BINS, np.nan))
    lines, path, _ = _solve(feet, facing, prior, TALL_M)
    spans = wall_spans(lines, path, np.isfinite(borders.foot))
    low, high = HEIGHT_RANGE_M[0], min(HEIGHT_RANGE_M[1], 0.9 * room.height_m)
    heights = np.append(np.arange(low, high, 0.01), prior)
    misfit = np.array([extent_misfit(spans, room.extent_m, h / prior) for h in heights.tolist()])
    if misfit[-1] == 0.0:
        return None
    return float(heights[int(np.argmin(misfit + ((heights - prior) / HEIGHT_SPREAD_M) ** 2))])


def _solve(
    borders: Borders, facing: np.ndarray, height: float, above: float
) -> tuple[list[WallLine], np.ndarray, float]:
    """Return the possible walls, the wall of each bin, and what that costs."""
    distances = np.stack([height / -borders.foot, above / borders.top], axis=1)
    lines = likely_walls(borders, distances) + list(UNSEEN_LINES)
    costs = _costs(borders, lines, height, above)
    axes = np.array([line.axis for line in lines])
    contrary = np.column_stack([facing[:, ::-1], facing.max(axis=1)])
    against = np.minimum(VOTE * contrary, MAX_VOTES)[:, axes]
    path, total = _cheapest(costs + np.where(np.isnan(borders.reach[:, :1]), 0.0, against), axes)
    return lines, path, total


def _costs(borders: Borders, lines: list[WallLine], height: float, above: float) -> np.ndarray:
    """Return the cost (b, k) of each wall in each bin."""
    costs = np.zeros((N_BINS, len(lines)))
    has_wall = ~np.isnan(borders.reach[:, 0])
    for index, line in enumerate(lines):
        facing = borders.direction @ np.array(line.outward)
        visible = facing > MIN_FACING
        reach = line.distance / np.where(visible, facing, 1.0)
        for slope, expected in ((borders.foot, -height / reach), (borders.top, above / reach)):
            off = (np.arctan(slope) - np.arctan(expected)) / BORDER_NOISE
            costs[:, index] += np.where(np.isnan(off), 0.0, np.minimum(off**2, OUTLIER))
        # Wall pixels under its foot or over its top cannot be of this wall.
        low, high = np.arctan(-height / reach), np.arctan(above / reach)
        beyond = np.fmax(low - np.arctan(borders.reach[:, 0]), 0.0)
        beyond = np.fmax(beyond, np.arctan(borders.reach[:, 1]) - high) / BEYOND_NOISE
        costs[:, index] += np.where(has_wall, np.minimum(beyond**2, OUTLIER), 0.0)
        # Of two walls that nothing tells apart, the one that is looked at more squarely.
        costs[:, index] += np.where(
            has_wall, (0.0 if line.seen else UNSEEN) + 0.2 * (1 - facing), 0
        )
        costs[~visible, index] = 4 * OUTLIER
    return costs


def _cheapest(costs: np.ndarray, axes: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the wall (b,) of each bin on the path of least cost, creases included; the cost."""
    turn = np.where((axes[:, None] == axes[None]) & (axes != OWN), JUMP, CREASE)
    turn = turn + SLANT * ((axes[:, None] == OWN) | (axes[None] == OWN))
    np.fill_diagonal(turn, 0.0)
    total = costs[0].copy()
    back = np.zeros(costs.shape, dtype=int)
    for index in range(1, len(costs)):
        ways = total[:, None] + turn
        back[index] = np.argmin(ways, axis=0)
        total = ways.min(axis=0) + costs[index]
    path = np.zeros(len(costs), dtype=int)
    path[-1] = int(np.argmin(total))
    for index in range(len(costs) - 1, 0, -1):
        path[index - 1] = back[index, path[index]]
    return path, float(total.min())


def _settle_creases(
    path: np.ndarray, lines: list[WallLine], borders: Borders, blind: np.ndarray
) -> np.ndarray:
    """Move creases inside a run of `blind` bins to where the two walls, both seen, meet."""
    azimuth = borders.azimuth
    settled = path.copy()
    for crease in np.nonzero(np.diff(path))[0]:
        first, second = lines[path[crease]], lines[path[crease + 1]]
        meeting = first.meets(second)
        if meeting is None or not (first.seen and second.seen):
            continue
        start = int(crease)
        while start >= 0 and blind[start] and path[start] == path[crease]:
            start -= 1
        end = int(crease) + 1
        while end < len(path) and blind[end] and path[end] == path[crease + 1]:
            end += 1
        meet = int(np.searchsorted(azimuth, np.arctan2(meeting[0], meeting[1])))
        meet = int(np.clip(meet, start + 1, end))
        settled[start + 1 : meet] = path[crease]
        settled[meet:end] = path[crease + 1]
    return settled


def _joined(
    path: np.ndarray, lines: list[WallLine], borders: Borders, blind: np.ndarray
) -> list[WallLine]:
    """Return the walls with an unseen one at the distance at which it meets its neighbour.

    Only creases count that something locates; of two unseen walls the wider one keeps its
    distance.
    """
    azimuth = borders.azimuth
    joined, done = list(lines), {index for index, line in enumerate(lines) if line.seen}
    creases = np.nonzero(np.diff(path))[0].tolist()
    while creases:
        # First those at a wall whose distance is known.
        crease = next((c for c in creases if path[c] in done or path[c + 1] in done), creases[0])
        creases.remove(crease)
        known, other = int(path[crease]), int(path[crease + 1])
        near = slice(max(0, crease - CREASE_BINS), crease + 1 + CREASE_BINS)
        if known in done and other in done:
            continue
        if known not in done and other not in done:
            done.add(known if (path == known).sum() >= (path == other).sum() else other)
        known, other = (known, other) if known in done else (other, known)
        if joined[known].meets(joined[other]) is None or blind[near].mean() > 0.5:
            continue
        angle = (azimuth[crease] + azimuth[crease + 1]) / 2
        toward = np.array([np.sin(angle), np.cos(angle)])
        share = [abs(float(toward @ np.array(joined[i].outward))) for i in (known, other)]
        reach = joined[known].distance / max(share[0], 1e-3)
        distance = float(np.clip(reach * share[1], *DISTANCE_RANGE_M))
        joined[other] = replace(joined[other], distance=distance, seen=joined[known].seen)
        done.add(other)
    return joined
