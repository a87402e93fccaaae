"""Walls of a photo in plan view: which wall a viewing direction meets.

In the Manhattan frame a wall is x = +-d or z = +-d (d metres from the camera). The foot of a wall,
where wall pixels stand on floor pixels, lies on the floor plane, so its slope below the horizon
gives the distance. The top under the ceiling gives it likewise. Viewing directions are binned by
azimuth (not by image column: with a pitched camera the crease of two walls crosses columns), and
dynamic programming finds the cheapest sequence of walls over the bins. The room's size in the plan
gives the scale. A door shows as floor that goes on beyond the foot of a wall, or as a farther wall
between two parts of one wall; what lies behind the door does not belong to the room.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from plan2scene.camera import Camera
from plan2scene.house import Room
from plan2scene.photos.camera.lines import Segments, residuals
from plan2scene.photos.labels.palette import CEILING, FLOOR, IGNORE, OTHER, WALL


@dataclass(frozen=True)
class PlaneSettings:
    """Constants of the planes of a photo.

    Source, where a field names no other: set by hand; ``benchmarks/cameras.py`` scores the planes
    of synthetic homes against their truth.
    """

    # Borders of the wall mask.
    #: Azimuth bins over the width of a photo.
    bins: int = 240
    #: Widest strip of other things (cornice, skirting) between a wall and its floor or ceiling:
    #: share of the photo's height.
    gap_share: float = 0.03
    #: Largest angle between a line segment and an axis that it runs along, radians.
    segment_noise: float = float(np.radians(2.0))

    # Candidate walls from feet and tops.
    max_candidates: int = 8  #: largest number of candidate walls that face a Manhattan direction
    min_support: int = 4  #: least number of feet and tops, over the bins, of a candidate wall
    #: Distances that are tried for a wall whose foot and top are both hidden, metres.
    unseen_distances_m: tuple[float, ...] = (3.0, 2.2, 1.6, 1.1, 0.7, 0.4)
    distance_range_m: tuple[float, float] = (0.3, 15.0)  #: distances that are accepted, metres
    #: Least cosine between a viewing direction and the normal of the wall that it meets (about 85
    #: degrees).
    min_facing: float = 0.08

    # The cheapest sequence of walls over the bins.
    #: Angular noise of a mask's border, radians.
    border_noise: float = float(np.radians(0.5))
    #: Largest cost of a foot or top (square of residual over noise), which bounds outliers.
    outlier: float = 9.0
    #: Noise of how far wall pixels reach beyond a wall's foot or top, radians.
    beyond_noise: float = float(np.radians(1.5))
    crease: float = 14.0  #: cost of a corner
    jump: float = 28.0  #: cost of a jump between parallel walls
    unseen: float = 0.4  #: cost per bin of a wall that no foot or top supports
    #: Bins on each side of a crease, at least half of which must show something; else the crease
    #: does not locate a wall.
    crease_bins: int = 6
    vote: float = 0.5  #: cost per bin of each segment that contradicts the wall's direction
    max_votes: float = 1.5  #: bound of that cost

    # Scale: the camera's height.
    #: Heights that are accepted, metres.
    height_range_m: tuple[float, float] = (0.8, 2.1)
    height_spread_m: float = 0.25  #: standard deviation of the height about its prior, metres
    min_height_bins: int = 8  #: least number of feet, and of tops, that give the height
    tall_m: float = 10.0  #: height of walls above the camera where tops are not used, metres
    camera_height_m: float = 1.5  #: prior of the camera's height above the floor, metres
    room_height_m: float = 2.6  #: height of a room where the plan gives none, metres

    # Scale: the room's extent in the plan.
    #: Least share of its bounding rectangle that a room fills; else its extent is not used.
    min_filled: float = 0.9
    min_wall_bins: int = 8  #: least number of bins in which a wall's foot is seen
    clearance_m: float = 0.3  #: least distance of a camera from the wall behind it, metres
    extent_spread: float = 0.06  #: spread of the log ratio of a span in the photo to the plan's
    extent_bound: float = 9.0  #: bound of a span's cost

    # What lies beyond the room.
    #: Least distance from a wall to what is seen through its door, along the view, metres.
    min_step_m: float = 0.3
    max_door_m: float = 2.6  #: widest opening that counts as a door, metres
    margin_share: float = 0.1  #: margin on the longest line in the room, share
    margin_m: float = 0.1  #: margin on the distance of walls, metres
    #: If a smaller share of a surface is within the room, all of it is kept: distances are wrong.
    min_left: float = 0.1

    # Planes.
    #: Largest number of walls of a photo; the largest are kept. Source: the paper's 10 planes.
    max_walls: int = 10
    min_share: float = 0.002  #: smallest plane, share of the photo's pixels

    # Rectification.
    #: Largest side of a rectified image, pixels.
    max_side_px: int = 2048
    min_grazing_deg: float = 15.0  #: least angle between a ray and the plane, degrees
    #: Bounds of the resolution, pixels per metre.
    resolution_range: tuple[float, float] = (60.0, 512.0)
    #: The part of a wall below this height above the floor is left out (skirting boards), metres.
    skirting_m: float = 0.12
    border_share: float = 0.005  #: width removed at the mask's border, share of the photo's width


PLANES = PlaneSettings()


@dataclass(frozen=True)
class Borders:
    """Borders of the wall mask in each of the b azimuth bins."""

    direction: np.ndarray  #: (b, 2) float64: Unit (x, z) of the bin's middle
    #: foot, top: (b,) float64: Slope (rise over horizontal distance) of the wall's foot (< 0) and
    #: top (> 0); NaN where not seen.
    foot: np.ndarray
    top: np.ndarray
    #: (b, 2) float64: 2nd and 98th percentile of the slopes of wall pixels; NaN if there are none.
    reach: np.ndarray
    bins: np.ndarray  #: (h, w) int: Bin of each pixel

    @property
    def azimuth(self) -> np.ndarray:
        """Return the azimuth (b,) of each bin's middle, radians from z towards x."""
        return np.arctan2(self.direction[:, 0], self.direction[:, 1])


def find_borders(labels: np.ndarray, camera: Camera) -> Borders:
    """Return feet and tops of the wall mask by azimuth."""
    rays = camera.rays_at(*np.indices(labels.shape))
    azimuth = np.arctan2(rays[..., 0], rays[..., 2])
    slope = rays[..., 1] / np.maximum(np.hypot(rays[..., 0], rays[..., 2]), 1e-9)
    low, high = float(azimuth.min()), float(azimuth.max())
    width = max((high - low) / PLANES.bins, 1e-9)
    bins = np.clip(((azimuth - low) / width).astype(int), 0, PLANES.bins - 1)
    middle = low + (np.arange(PLANES.bins) + 0.5) * width
    wall = labels == WALL
    gap = max(1, round(PLANES.gap_share * len(labels)))
    foot = _borders_on(labels, FLOOR, gap)
    top = _borders_on(labels[::-1], CEILING, gap)[::-1]
    foot &= slope < -0.02
    top &= slope > 0.02
    reach = np.stack([_by_bin(bins, slope, wall, 2.0), _by_bin(bins, slope, wall, 98.0)], axis=1)
    return Borders(
        direction=np.stack([np.sin(middle), np.cos(middle)], axis=1),
        foot=_by_bin(bins, slope, foot, 50.0),
        top=_by_bin(bins, slope, top, 50.0),
        reach=reach,
        bins=bins,
    )


def _borders_on(labels: np.ndarray, below: int, gap: int) -> np.ndarray:
    """Return the wall pixels (h, w) bool with label `below` at most `gap` rows under them.

    Only pixels of other things or ignored pixels may be between: skirting, cornice, a cable.
    """
    wall = labels == WALL
    borders = np.zeros_like(wall)
    between = wall[:-1].copy()
    for step in range(1, gap + 1):
        reached = labels[step:]
        borders[:-step] |= between & (reached == below)
        between = (between & ((reached == OTHER) | (reached == IGNORE)))[:-1]
    return borders


def _by_bin(bins: np.ndarray, values: np.ndarray, chosen: np.ndarray, q: float) -> np.ndarray:
    """Return the q-th percentile of the chosen values of each bin, NaN where there are none."""
    result = np.full(PLANES.bins, np.nan)
    where, value = bins[chosen], values[chosen]
    order = np.lexsort((value, where))
    where, value = where[order], value[order]
    filled, start, count = np.unique(where, return_index=True, return_counts=True)
    result[filled] = value[start + ((count - 1) * q / 100.0).round().astype(int)]
    return result


def facing_votes(
    segments: np.ndarray | None, labels: np.ndarray, camera: Camera, bins: np.ndarray
) -> np.ndarray:
    """Return for each bin the number of segments on walls along z and along x, (b, 2).

    A segment along z lies on a wall that faces x (axis 0), one along x on a wall that faces z.
    """
    votes = np.zeros((PLANES.bins, 2))
    if segments is None or not len(segments):
        return votes
    lines = Segments(segments, (camera.cx, camera.cy), np.ones(len(segments)))
    off = np.abs(residuals(*lines.rays(camera.focal_px), camera.matrix))
    rows, columns = labels.shape
    start, along = segments[:, :2], segments[:, 2:] - segments[:, :2]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1) / lines.length[:, None]
    middle = start + along / 2
    touches = np.zeros(len(segments), dtype=bool)
    for side in (-4.0, 4.0):
        point = np.round(middle + side * across).astype(int)
        x, y = np.clip(point[:, 0], 0, columns - 1), np.clip(point[:, 1], 0, rows - 1)
        touches |= labels[y, x] == WALL
    for axis, other in ((2, 0), (0, 2)):
        clear = (off[:, axis] < PLANES.segment_noise) & (off[:, other] > 3 * PLANES.segment_noise)
        clear &= touches & (off[:, 1] > 3 * PLANES.segment_noise)
        for first, last in segments[clear].reshape(-1, 2, 2).round().astype(int):
            ends = [
                bins[np.clip(y, 0, rows - 1), np.clip(x, 0, columns - 1)] for x, y in (first, last)
            ]
            votes[min(ends) : max(ends) + 1, 0 if axis == 2 else 1] += 1.0
    return votes


@dataclass(frozen=True)
class WallLine:
    """The wall ``outward . (x, z) = distance``, metres from the camera.

    `outward` is a unit vector away from the camera; `seen` tells whether the wall's foot or top
    was seen.
    """

    outward: tuple[float, float]
    distance: float
    seen: bool

    @property
    def axis(self) -> int:
        """Return 0 for a wall x = +-d, 1 for z = +-d."""
        return 0 if self.outward[0] else 1

    def meets(self, other: WallLine) -> np.ndarray | None:
        """Return the corner (x, z) with another wall; None for (nearly) parallel ones."""
        normals = np.array([self.outward, other.outward])
        if abs(float(np.linalg.det(normals))) < 0.1:
            return None
        return np.asarray(np.linalg.solve(normals, [self.distance, other.distance]))


#: Outward directions of Manhattan walls.
DIRECTIONS = ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
#: Walls whose foot and top are both hidden: the farthest that no wall pixel contradicts is taken.
UNSEEN_LINES = tuple(
    WallLine(outward, distance, False)
    for outward in DIRECTIONS
    for distance in PLANES.unseen_distances_m
)


def likely_walls(borders: Borders, distances: np.ndarray) -> list[WallLine]:
    """Return the walls that most feet and tops lie on, the best supported first.

    `distances` (b, 2) are the horizontal distances of foot and top from the camera, metres, NaN
    where not seen.
    """
    supported: list[tuple[float, WallLine]] = []
    for outward in DIRECTIONS:
        facing = borders.direction @ np.array(outward)
        offset = (distances * facing[:, None])[facing > PLANES.min_facing]
        offset = np.sort(offset[~np.isnan(offset)])
        low, high = PLANES.distance_range_m
        offset = offset[(offset >= low) & (offset <= high)]
        supported += [
            (count, WallLine(outward, distance, True))
            for count, distance in _peaks(offset)
            if count >= PLANES.min_support
        ]
    supported.sort(key=lambda item: -item[0])
    return [line for _, line in supported[: PLANES.max_candidates]]


def _peaks(offset: np.ndarray) -> list[tuple[int, float]]:
    """Return (count, median) of the largest groups of sorted distances within +-6 %."""
    groups: list[tuple[int, float]] = []
    left = offset
    while len(left) >= PLANES.min_support and len(groups) < 4:
        first = np.searchsorted(left, left / 1.06)
        last = np.searchsorted(left, left * 1.06, side="right")
        best = int(np.argmax(last - first))
        group = left[first[best] : last[best]]
        groups.append((len(group), float(np.median(group))))
        left = np.concatenate([left[: first[best]], left[last[best] :]])
    return groups


@dataclass(frozen=True)
class RoomSize:
    """A room's height and extent (the sides of its rectangle, None where unknown), metres."""

    height_m: float
    extent_m: tuple[float, float] | None = None

    @classmethod
    def of(cls, room: Room) -> RoomSize:
        """Return the size of a room of the plan."""
        return cls(room.height, room_extent(room))


def room_extent(room: Room) -> tuple[float, float] | None:
    """Return the sides in metres of a room's rectangle; None for one that is no rectangle."""
    from plan2scene.plans.geometry import room_polygon

    outline = room_polygon(room)
    box = outline.minimum_rotated_rectangle
    if (
        outline.area <= 0.0
        or box.geom_type != "Polygon"
        or outline.area < PLANES.min_filled * box.area
    ):
        return None
    corners = np.array(box.exterior.coords)
    first, second = np.linalg.norm(np.diff(corners, axis=0), axis=1)[:2].tolist()
    return float(first), float(second)


def wall_spans(
    lines: Sequence[WallLine], path: np.ndarray, foot: np.ndarray
) -> list[tuple[float, bool]]:
    """Return for each Manhattan axis the span of the walls, and whether both sides are seen.

    `path` (b,) int is the index into `lines` of each azimuth bin's wall. `foot` (b,) bool are the
    bins that show a wall's foot; only those count. The result is (distance between opposite walls,
    True), (distance of the only wall from the camera, False), or (0, False), metres.
    """
    count = np.bincount(path[foot], minlength=len(lines))
    spans: list[tuple[float, bool]] = []
    for axis in (0, 1):
        sides = []
        for sign in (1.0, -1.0):
            count_and_distance = [
                (int(count[index]), line.distance)
                for index, line in enumerate(lines)
                if line.seen and line.outward[axis] == sign and count[index] >= PLANES.min_wall_bins
            ]
            sides += [max(count_and_distance)[1]] if count_and_distance else []
        spans.append((float(sum(sides)), len(sides) == 2))
    return spans


def extent_misfit(
    spans: Sequence[tuple[float, bool]], extent_m: tuple[float, float], scale: float
) -> float:
    """Return the cost of spans (`wall_spans`) times `scale` against the sides of a room.

    Two opposite walls must be as far apart as the plan says. A single wall must be nearer than that
    by `PLANES.clearance_m`, because the camera is inside the room; its cost is 0 then. It is not
    known which side lies along which axis: the cheaper assignment counts.
    """
    return min(
        sum(
            _misfit(scale * span, both, side) for (span, both), side in zip(spans, way, strict=True)
        )
        for way in (extent_m, extent_m[::-1])
    )


def _misfit(span: float, both: bool, side: float) -> float:
    """Return the bounded cost of a span against a side of the room."""
    limit = side if both else max(side - PLANES.clearance_m, 0.1)
    if span <= 0.0 or (not both and span <= limit):
        return 0.0
    return min((float(np.log(span / limit)) / PLANES.extent_spread) ** 2, PLANES.extent_bound)


def room_reach(
    lines: Sequence[WallLine], path: np.ndarray, direction: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the distance (b,) to the room's walls by direction, metres, inf if no wall gives it.

    Also returns the directions (b,) bool that look through a door, with the same wall on both sides
    of it. `path` (b,) int is the wall that each azimuth bin meets, -1 for none. `direction` (b, 2)
    float64 is the unit (x, z) of each bin's middle.
    """
    seen = np.array([*(line.seen for line in lines), False])
    outward = np.array([line.outward for line in lines]).reshape(-1, 2)
    distance = np.array([line.distance for line in lines])
    away = distance / np.maximum(direction @ outward.T, 1e-3)
    met = np.column_stack([away, np.zeros(len(path))])[np.arange(len(path)), path]
    reach = np.where(seen[path], met, np.inf)
    through = np.zeros(len(path), bool)
    for index in np.flatnonzero(seen):
        wall_bins = np.flatnonzero(path == index)
        between = np.arange(wall_bins[0], wall_bins[-1] + 1) if len(wall_bins) else wall_bins
        for run in _runs(between[met[between] > away[between, index] + PLANES.min_step_m]):
            ends = direction[run[[0, -1]]] * away[run[[0, -1]], index, None]
            if np.linalg.norm(ends[1] - ends[0]) < PLANES.max_door_m:
                reach[run] = np.minimum(reach[run], away[run, index])
                through[run] = True
    return reach, through


def within_room(
    mask: np.ndarray, camera: Camera, drop_m: float, reach: np.ndarray, longest_m: float
) -> np.ndarray:
    """Return the pixels (h, w) bool of a floor's or ceiling's mask that are not beyond the room.

    The surface is `drop_m` metres below the camera, negative for a ceiling. `reach` (h, w) float64
    is the `room_reach` of each pixel's direction, `longest_m` the longest line in the room, metres.
    """
    rows, columns = np.nonzero(mask)
    if not len(rows):
        return mask
    rays = camera.rays_at(rows, columns)
    fall = np.maximum(-rays[:, 1] * np.sign(drop_m), 1e-9)
    away = abs(drop_m) * np.hypot(rays[:, 0], rays[:, 2]) / fall
    limit = np.minimum(
        reach[rows, columns] + PLANES.margin_m, longest_m * (1 + PLANES.margin_share)
    )
    near = away < limit
    if near.mean() < PLANES.min_left:
        return mask
    kept = np.zeros_like(mask)
    kept[rows[near], columns[near]] = True
    return kept


def _runs(numbers: np.ndarray) -> list[np.ndarray]:
    """Split sorted integers into runs of consecutive numbers."""
    return [run for run in np.split(numbers, np.flatnonzero(np.diff(numbers) > 1) + 1) if len(run)]


@dataclass(frozen=True)
class TracedWalls:
    """Walls of a photo and the wall of each pixel."""

    lines: list[WallLine]  #: the walls, in the order of `owner`
    #: (h, w) int16: Index into `lines` of the wall that a pixel's azimuth meets; -1 for none.
    owner: np.ndarray
    #: (h, w) float64: Distance of the room's wall at a pixel's azimuth, metres; inf if unknown.
    reach: np.ndarray
    #: (h, w) bool: Pixels whose azimuth looks through a door, at another room's walls.
    through: np.ndarray
    camera_height_m: float  #: height of the camera above the floor, metres
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

    `solve_height` tells whether the room's height is known, so that it may give the camera's.
    `segments` (s, 4), pixels, are line segments of the photo: horizontal ones on a wall help to
    find which way it faces, if neither its foot nor its top is seen.
    """
    borders = find_borders(labels, camera)
    facing = facing_votes(segments, labels, camera, borders.bins)
    height, source = camera_height_m, "camera_height"
    solved = _camera_height(borders, facing, height, room.height_m) if solve_height else None
    if solved is not None:
        height, source = solved, "room_height"
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

    A search finds the height at which feet and tops agree best on common walls. Then the median
    over the bins that show both refines it, or, with too few of them, a finer search.
    """
    low, high = PLANES.height_range_m[0], min(PLANES.height_range_m[1], 0.9 * room_height_m)
    seen = min(np.isfinite(borders.foot).sum(), np.isfinite(borders.top).sum())
    if high <= low or seen < PLANES.min_height_bins:
        return None

    def cost(height: float) -> float:
        unlikely = 2.0 * ((height - prior) / PLANES.height_spread_m) ** 2
        return _solve(borders, facing, height, room_height_m - height)[2] + unlikely

    best = min(np.arange(low, high, 0.1).tolist(), key=cost)
    each = room_height_m / (1.0 + borders.top / -borders.foot)
    each = each[np.abs(each - best) < 0.15]
    if len(each) >= PLANES.min_height_bins:
        return float(np.clip(np.median(each), low, high))
    finer = np.arange(max(low, best - 0.08), min(high, best + 0.09), 0.02)
    return float(min(finer.tolist(), key=cost))


def _height_by_extent(
    borders: Borders, facing: np.ndarray, prior: float, room: RoomSize
) -> float | None:
    """Return the camera's height at which walls fit the room's extent; None if `prior` fits, too.

    Only feet are used: their distances are proportional to the height. None without an extent, too.
    """
    if room.extent_m is None:
        return None
    feet = replace(borders, top=np.full(PLANES.bins, np.nan))
    lines, path, _ = _solve(feet, facing, prior, PLANES.tall_m)
    spans = wall_spans(lines, path, np.isfinite(borders.foot))
    low, high = PLANES.height_range_m[0], min(PLANES.height_range_m[1], 0.9 * room.height_m)
    heights = np.append(np.arange(low, high, 0.01), prior)
    misfit = np.array([extent_misfit(spans, room.extent_m, h / prior) for h in heights.tolist()])
    if misfit[-1] == 0.0:
        return None
    return float(
        heights[int(np.argmin(misfit + ((heights - prior) / PLANES.height_spread_m) ** 2))]
    )


def _solve(
    borders: Borders, facing: np.ndarray, height: float, above: float
) -> tuple[list[WallLine], np.ndarray, float]:
    """Return the candidate walls, the index of each bin's wall, and the total cost."""
    distances = np.stack([height / -borders.foot, above / borders.top], axis=1)
    lines = likely_walls(borders, distances) + list(UNSEEN_LINES)
    costs = _costs(borders, lines, height, above)
    axes = np.array([line.axis for line in lines])
    against = np.minimum(PLANES.vote * facing[:, ::-1], PLANES.max_votes)[:, axes]
    path, total = _cheapest(costs + np.where(np.isnan(borders.reach[:, :1]), 0.0, against), axes)
    return lines, path, total


def _costs(borders: Borders, lines: list[WallLine], height: float, above: float) -> np.ndarray:
    """Return the cost (b, k) of each wall in each bin."""
    costs = np.zeros((PLANES.bins, len(lines)))
    has_wall = ~np.isnan(borders.reach[:, 0])
    for index, line in enumerate(lines):
        facing = borders.direction @ np.array(line.outward)
        visible = facing > PLANES.min_facing
        reach = line.distance / np.where(visible, facing, 1.0)
        for slope, expected in ((borders.foot, -height / reach), (borders.top, above / reach)):
            off = (np.arctan(slope) - np.arctan(expected)) / PLANES.border_noise
            costs[:, index] += np.where(np.isnan(off), 0.0, np.minimum(off**2, PLANES.outlier))
        # Wall pixels below its foot or above its top cannot belong to this wall.
        low, high = np.arctan(-height / reach), np.arctan(above / reach)
        beyond = np.fmax(low - np.arctan(borders.reach[:, 0]), 0.0)
        beyond = np.fmax(beyond, np.arctan(borders.reach[:, 1]) - high) / PLANES.beyond_noise
        costs[:, index] += np.where(has_wall, np.minimum(beyond**2, PLANES.outlier), 0.0)
        # Of two walls that fit equally well, prefer the one that is seen less obliquely.
        costs[:, index] += np.where(
            has_wall, (0.0 if line.seen else PLANES.unseen) + 0.2 * (1 - facing), 0
        )
        costs[~visible, index] = 4 * PLANES.outlier
    return costs


def _cheapest(costs: np.ndarray, axes: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the index (b,) of each bin's wall on the cheapest path, and its cost with creases."""
    turn = np.where(axes[:, None] == axes, PLANES.jump, PLANES.crease)
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
    """Move creases inside a run of `blind` bins to the corner of two walls that are both seen."""
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
    """Return the walls; each unseen one is moved to meet its neighbour at their crease.

    Creases among mostly `blind` bins are ignored. Of two unseen walls the wider one keeps its
    distance.
    """
    azimuth = borders.azimuth
    joined, done = list(lines), {index for index, line in enumerate(lines) if line.seen}
    creases = np.nonzero(np.diff(path))[0].tolist()
    while creases:
        # Creases at a wall of known distance come first.
        crease = next((c for c in creases if path[c] in done or path[c + 1] in done), creases[0])
        creases.remove(crease)
        known, other = int(path[crease]), int(path[crease + 1])
        near = slice(max(0, crease - PLANES.crease_bins), crease + 1 + PLANES.crease_bins)
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
        distance = float(np.clip(reach * share[1], *PLANES.distance_range_m))
        joined[other] = replace(joined[other], distance=distance, seen=joined[known].seen)
        done.add(other)
    return joined
