"""Find the pattern of a floor: the lines that repeat in all its views at one size."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d

from plan2scene.photos.patterns.joints import (
    DISTANCES,
    JOINTS,
    Direction,
    along,
    moved,
    next_row,
    refined,
    run_on,
)
from plan2scene.photos.patterns.views import FloorView
from plan2scene.photos.patterns.zigzag import find_zigzag


@dataclass(frozen=True)
class FindSettings:
    """Constants chosen on renderings of procedural materials and by looking at real floors."""

    same_size: float = 0.1  #: log ratio by which the scales of photos of one floor may differ
    most_m2: float = 3.0  #: limit of the area by which a view is weighted
    enough_m2: float = 2.0  #: total area of the views for full confidence
    grain: float = 2.0  #: least ratio of contrast kept along and across lines for a clear grain
    wood: float = 3.0  #: the same ratio for wood, over all views
    least_kept: float = 0.2  #: least contrast kept along the grain of wood
    grainy: tuple[float, float] = (0.05, 0.15)  #: `plain` and `clear` for scores of :func:`_combed`
    part: float = 0.7  #: a third or fifth of a distance is the period from this share of its score
    plain: float = 0.16  #: score of floors without joints: confidence 0
    clear: float = 0.36  #: least score of joints beyond doubt: confidence 1
    believed: float = 0.4  #: a floor with a lower confidence counts as plain
    usual_looks: tuple[float, float] = (0.45, 0.26)  #: prior shares of floors of wood and of tiles
    by_looks: float = 3.0  #: weight of the log odds of wood against tiles by looks
    looked: float = 3.1  #: subtracted after this weight: value of floors that may be either
    #: Log odds of wood by length over width: short, long, not known.
    by_length: tuple[float, float, float] = (-1.2, 0.7, 1.2)
    seen_px: float = 5e4  #: photo pixels of a floor at which joints are missed half of the time
    usual: float = 0.9  #: weight of a width at the house's camera height; 1 at the view's own
    located: int = 2  #: least number of located views for which a room has its own direction
    least_length: float = 0.12  #: least score of the joints across rows
    alone: float = 2.0  #: half of that is enough at this many times the score of other lengths
    breaks: float = 0.3  #: rows: largest rise of the joints' likeness along them, over its start
    fades: float = 0.25  #: rows: least likeness of the joints half a metre along, over its start
    whole: float = 0.3  #: least likeness of a floor of square tiles to itself, moved by a tile
    #: Joints are light only if light lines are this many times as clear as dark ones, since a dark
    #: joint has bright sides. Seen on two real flats (development), 1.0 and 2.1.
    light: float = 1.2
    square: float = 0.12  #: largest log ratio of the sides of square tiles
    zigzag_views: int = 12  #: largest number of views that are searched for slanting planks
    zigzag: tuple[float, float] = (0.06, 0.12)  #: scores for confidence 0 and 1
    plank: float = 2.2  #: least length over width of planks
    widest_plank_m: float = 0.3  #: largest width of planks


FIND = FindSettings()
NAN = float("nan")


@dataclass(frozen=True)
class FoundPattern:
    """The pattern of a floor."""

    #: ``planks``, ``tiles``, ``herringbone``, ``chevron``, ``plain``, or ``other`` (it
    #: repeats, but not in rows, such as a basket weave)
    kind: str
    #: width_m, length_m: sides of a unit with half a joint on each side; NaN if unknown (planks of
    #: many lengths)
    width_m: float = NAN
    length_m: float = NAN
    width_spread: float = NAN  #: standard deviation of the width between photos, over the width
    #: direction in the plan from +x towards +z: of planks or the tiles' longer side, [0, 180); of
    #: square tiles, [0, 90); of the columns of a herringbone or chevron. NaN if no located photo
    #: shows it.
    direction_deg: float = NAN
    offset: float = 0.0  #: shift of each row against the row before, share of the length
    confidence: float = 0.0  #: probability that the kind is right
    #: how joints differ from the units: ``dark``, ``light``, or only a ``step`` of tone
    line: str = ""
    photos: tuple[str, ...] = ()  #: photos that show it
    located: int = 0  #: number of located views that share the direction
    slant_deg: float = 0.0  #: angle between the units and the direction; 0 for rows


@dataclass(frozen=True)
class Reading:
    """One view's measurement of a pattern: direction, width of a unit (metres) and score."""

    view: FloorView
    direction: Direction
    width_m: float
    score: float

    @property
    def weight(self) -> float:
        """Return the weight of this view among all views."""
        return self.score * _area(self.view)


def find_pattern(
    views: Sequence[FloorView], looks: tuple[float, float] | None = None
) -> tuple[FoundPattern, list[Reading]]:
    """Return the pattern of the floor that views show, and the measurement of each view.

    `looks` are the probabilities that the floor is of wood and of tiles, by its looks, if known.
    Together with the length of units they decide between planks and tiles. The floor is plain if no
    joints are evident; that confidence depends on how much of it was seen, and on the looks.
    """
    if not views:
        return FoundPattern("plain"), []
    slanting = _zigzag(views)
    if slanting is not None:
        return slanting
    grainy = _grainy(views)
    for widest in (np.inf, FIND.widest_plank_m):
        confidence, readings = _rows(views, grainy, widest)
        if not readings or confidence < FIND.believed:
            unseen = (1.0 - confidence) * _without_joints(views, sum(looks or FIND.usual_looks))
            return FoundPattern("plain", confidence=unseen), []
        width, spread = _width(readings)
        ratio, offset = _length(readings)
        if not grainy or np.isfinite(ratio) or width <= FIND.widest_plank_m:
            break  # else it is wood, but wider than planks are: search for narrower rows
    photos = tuple(dict.fromkeys(r.view.photo for r in readings))
    line = _line(readings)
    kind, square = "planks", abs(np.log(ratio)) < FIND.square if np.isfinite(ratio) else False
    if square or (not np.isfinite(ratio) and width > FIND.widest_plank_m):
        kind, ratio, square = "tiles", 1.0, True
    elif ratio < 1.0:
        readings = [_turned(r, ratio) for r in readings]
        width, ratio, offset = width * ratio, 1.0 / ratio, 0.0
    if ratio < FIND.plank or width > FIND.widest_plank_m:
        kind = "tiles"
    wood = _wood(looks, ratio)
    if wood > 0.5 and kind == "tiles" and width <= FIND.widest_plank_m:
        kind, ratio, square, offset = "planks", NAN, False, 0.0  # the planks' ends were not seen
    elif wood <= 0.5 and kind == "planks":
        if not np.isfinite(ratio):  # shadows of a blind, a striped carpet
            return FoundPattern("plain", confidence=1.0 - confidence * wood), []
        kind = "tiles"
    if width <= FIND.widest_plank_m:
        confidence *= wood if kind == "planks" else 1.0 - wood
    direction, located = _direction(readings, 90.0 if square else 180.0)
    whole = square and _repeats_whole(readings)
    if not whole and not grainy and not _in_rows(readings, line):
        return FoundPattern("other", width, confidence=confidence, photos=photos), []
    sizes = width, ratio * width, spread
    found = FoundPattern(kind, *sizes, direction, offset, confidence, line, photos, located)
    return found, readings


def _rows(views: Sequence[FloorView], grainy: bool, widest_m: float) -> tuple[float, list[Reading]]:
    """Return the confidence in rows up to a width, and each view's measurement of the best one."""
    curves = np.array([lines_of(view) for view in views])
    weights = np.array([_area(view) for view in views]) / sum(map(_area, views))
    reach = 2 * round(100 * FIND.same_size) + 1
    single = np.array([_single(curve) for curve in curves]) * np.less_equal(DISTANCES, widest_m)
    pooled = weights @ maximum_filter1d(single, reach, axis=1)
    found = _sure(views, pooled, (FIND.plain, FIND.clear))
    if found[0] < FIND.believed and grainy:
        # Wood: stain and gloss hide joints, so scores at multiples of a distance are added to it.
        combed = weights @ maximum_filter1d(_combed(curves), reach, axis=1)
        found = max(_sure(views, combed, FIND.grainy), found, key=lambda one: one[0])
    return found


def _wood(looks: tuple[float, float] | None, ratio: float) -> float:
    """Return the probability that units in rows are wood, from looks and length over width."""
    odds = np.log(FIND.usual_looks[0] / FIND.usual_looks[1])
    if looks is not None:
        odds += FIND.by_looks * np.log(max(looks[0], 1e-3) / max(looks[1], 1e-3)) - FIND.looked
    short, long, unknown = FIND.by_length
    odds += unknown if not np.isfinite(ratio) else short if ratio < FIND.plank else long
    return float(1.0 / (1.0 + np.exp(-odds)))


def _without_joints(views: Sequence[FloorView], jointed: float) -> float:
    """Return the probability that a floor has no joints if its views show none.

    `jointed` is the prior probability that it has joints.
    """
    pixels = sum(view.square_m * view.px_per_m**2 for view in views)
    missed = FIND.seen_px / (FIND.seen_px + pixels)
    return (1.0 - jointed) / (1.0 - jointed + jointed * missed)


def _zigzag(views: Sequence[FloorView]) -> tuple[FoundPattern, list[Reading]] | None:
    """Return the herringbone or chevron that the largest views show; None if there is none."""
    views = sorted(views, key=_area, reverse=True)[: FIND.zigzag_views]
    weights = np.array([_area(view) for view in views])
    shown = find_zigzag(views, weights, FIND.same_size)
    if shown is None:
        return None
    found, score, slants = shown
    none, sure = FIND.zigzag
    confidence = float(np.clip((score - none) / (sure - none), 0.0, 1.0))
    if confidence < FIND.believed:
        return None
    readings = [
        Reading(s.view, Direction(s.columns_deg, s.columns, 0.0), width, score)
        for s, width, score in slants
    ]
    width, spread = _width(readings)
    direction, located = _direction(readings, 180.0)
    pattern = FoundPattern(
        found.kind,
        width,
        found.length_m * width / found.width_m,
        spread,
        direction,
        confidence=confidence,
        photos=tuple(dict.fromkeys(r.view.photo for r in readings)),
        located=located,
        slant_deg=found.slant_deg,
    )
    return pattern, readings


def _area(view: FloorView) -> float:
    """Return the area by which a view is weighted: its own up to a limit, square metres."""
    return min(view.square_m, FIND.most_m2)


def lines_of(view: FloorView) -> np.ndarray:
    """Return how clearly lines of a view repeat (n,) at each of `DISTANCES`, 0..2."""
    return np.asarray(np.max([direction.scores for direction in _likely(view)], axis=0))


def _likely(view: FloorView) -> list[Direction]:
    """Return the directions that long joints may have: only the first if it shows a clear grain."""
    first, second = view.directions
    return [first] if first.kept > FIND.grain * second.kept else [first, second]


def _sure(
    views: Sequence[FloorView], pooled: np.ndarray, scores: tuple[float, float]
) -> tuple[float, list[Reading]]:
    """Return the confidence in joints at the best distance, and each view's measurement of them.

    `pooled` (n,) are the scores of all views together, `scores` those for confidence 0 and 1.
    """
    (none, clear), k = scores, int(pooled.argmax())
    readings = [_read(view, float(DISTANCES[k])) for view in views]
    readings = [r for r in readings if r.score >= 0.5 * none]
    shown = min(sum(r.view.square_m for r in readings) / FIND.enough_m2, 1.0)
    sure = shown * (pooled[k] - none) / (clear - none)  # clear joints make up for a small area
    return float(np.clip(sure, 0.0, 1.0)), readings


def _grainy(views: Sequence[FloorView]) -> bool:
    """Return whether a floor has the contrast of wood: kept along one direction, lost across it."""
    weights = [_area(view) for view in views]
    kept = np.average([[d.kept for d in view.directions] for view in views], 0, weights)
    return bool(kept[0] > max(FIND.least_kept, FIND.wood * kept[1]))


def _combed(curves: np.ndarray) -> np.ndarray:
    """Return the mean of scores (m, n) at each distance and at three and five times it."""
    near = maximum_filter1d(curves, 5, axis=1)
    total = curves.copy()
    for times in (3.0, 5.0):
        shift = round(100 * np.log(times))
        total[:, :-shift] += near[:, shift:]
    return total / 3.0


def _single(scores: np.ndarray) -> np.ndarray:
    """Return a view's scores (n,), set to 0 at distances that are 3 or 5 times a shorter period.

    The likeness at an odd multiple of a period is as high as at the period itself.
    """
    near, single = maximum_filter1d(scores, 13), scores.copy()
    for times in (3.0, 5.0):
        shift = round(100 * np.log(times))
        single[shift:][near[:-shift] >= FIND.part * scores[shift:]] = 0.0
    return single


def _read(view: FloorView, width_m: float) -> Reading:
    """Measure the joints in one view, assuming that they are about `width_m` apart."""
    options = [(d, *d.near(width_m, 2 * FIND.same_size)) for d in _likely(view)]
    direction, width, score = max(options, key=lambda option: option[2])
    return Reading(view, direction, width, score)


def _turned(reading: Reading, ratio: float) -> Reading:
    """Return the reading of the perpendicular lines, whose distance is `ratio` times the width."""
    first, second = reading.view.directions
    other = second if reading.direction is first else first
    return Reading(reading.view, other, reading.width_m * ratio, reading.score)


def _length(readings: Sequence[Reading]) -> tuple[float, float]:
    """Return length over width (NaN if nothing repeats) and the offset of the next row."""
    weights = np.array([r.weight for r in readings])
    kinds = [along(r.direction.view, r.width_m) for r in readings]
    curves = [np.max(list(found.values()), axis=0) for found in kinds]
    shifts = [round(100 * np.log(r.width_m / 0.1)) for r in readings]
    # The ratio of length to width does not depend on the scale of a photo.
    size = len(DISTANCES)
    reach = max(map(abs, shifts), default=0)
    wide = np.zeros((len(readings), size + 2 * reach))
    for row, curve, shift in zip(wide, curves, shifts, strict=True):
        row[reach - shift : reach - shift + size] = curve
    pooled = weights @ maximum_filter1d(wide, 7, axis=1) / weights.sum()
    k = int(_single(pooled).argmax())
    others = pooled[np.abs(np.arange(len(pooled)) - k) > 100 * FIND.same_size]
    alone = max(0.5 * FIND.least_length, FIND.alone * float(others.max(initial=0.0)))
    if pooled[k] < min(FIND.least_length, alone):
        return NAN, 0.0
    at = k - reach
    ratio = float(DISTANCES[0] * np.exp(0.01 * at) / 0.1)
    lengths, offsets, counts = [], [], []
    for r, curve, found, shift in zip(readings, curves, kinds, shifts, strict=True):
        low, high = max(at + shift - 5, 0), min(at + shift + 6, size)
        if low >= high or curve[low:high].max() < 0.5 * FIND.least_length:
            continue
        length_m = refined(curve, low + int(curve[low:high].argmax()))
        line = max(found, key=lambda name: found[name][low:high].max())
        lengths.append(length_m / r.width_m)
        offsets.append(next_row(r.direction.view, r.width_m, length_m, line))
        counts.append(r.weight * float(curve[low:high].max()))
    if not lengths:
        return ratio, 0.0
    turn = np.exp(2j * np.pi * np.array(offsets)) @ np.array(counts)
    return _middle(lengths, counts)[0], float(np.angle(turn) / (2 * np.pi) % 1.0)


def _in_rows(readings: Sequence[Reading], line: str) -> bool:
    """Return whether joints continue through the floor, so that its units lie in rows."""
    curves = np.array([run_on(r.direction.view, r.width_m, line) for r in readings])
    weights = np.array([[r.weight] for r in readings]) * np.isfinite(curves)
    total = weights.sum(axis=0)
    shift_count = int(np.argmin(np.r_[total > 0.3 * total[0], False]))
    if shift_count < 10:
        return True
    mean = (np.nan_to_num(curves) * weights).sum(axis=0)[:shift_count] / total[:shift_count]
    smooth = np.convolve(mean, np.full(5, 0.2), "valid") / max(float(mean[:12].mean()), 1e-6)
    again = float((smooth - np.minimum.accumulate(smooth)).max())
    return (
        again <= FIND.breaks
        and float(smooth[35:55].mean() if shift_count > 50 else 1.0) > FIND.fades
    )


def _repeats_whole(readings: Sequence[Reading]) -> bool:
    """Return whether a floor is like itself when moved by one square down and to a side.

    Square tiles are, even if veins hide their joints; the boards of a basket weave are not.
    """
    alike = [moved(r.direction.view, r.width_m) for r in readings]
    return bool(np.average(alike, weights=[r.weight for r in readings]) >= FIND.whole)


def _line(readings: Sequence[Reading]) -> str:
    """Return the kind of line at which the joints are clearest."""
    worth: dict[str, float] = defaultdict(float)
    for r in readings:
        k = int(np.abs(DISTANCES - r.width_m).argmin())
        for name, scores in r.direction.lines.items():
            worth[name] += r.weight * float(scores[max(k - 3, 0) : k + 4].max())
    if worth["light"] < FIND.light * worth["dark"]:
        worth["light"] = 0.0
    return max(worth, key=lambda name: worth[name])


def _middle(values: Sequence[float], weights: Sequence[float]) -> tuple[float, float]:
    """Return the mean of positive values near their weighted median, and the log spread of all."""
    order = np.argsort(values)
    ordered, heavy = np.log(np.array(values)[order]), np.array(weights)[order]
    middle = ordered[np.searchsorted(np.cumsum(heavy), 0.5 * heavy.sum())]
    heavy = heavy / heavy.sum()
    spread = float(np.sqrt(heavy @ (ordered - middle) ** 2))
    near = heavy * (np.abs(ordered - middle) <= FIND.same_size)
    return float(np.exp(near @ ordered / near.sum())), spread


def _width(readings: Sequence[Reading]) -> tuple[float, float]:
    """Return the width that views agree on, and its spread.

    Each view counts at its own scale and, with less weight, at the house's usual camera height.
    """
    widths = [r.width_m * scale for r in readings for scale in (1.0, r.view.usual)]
    weights = [r.weight * worth for r in readings for worth in (1.0, FIND.usual)]
    return _middle(widths, weights)


def _direction(readings: Sequence[Reading], turn: float) -> tuple[float, int]:
    """Return the direction in the plan modulo `turn` degrees that most located views share.

    It is NaN if there are no located views. The second value is the number of views that share it.
    """
    weighted_angles = [(r.direction.angle_deg % turn, r.weight) for r in readings if r.view.in_plan]
    if not weighted_angles:
        return NAN, 0
    angles, weights = (np.array(column) for column in zip(*weighted_angles, strict=True))
    away = np.abs((angles[:, None] - angles + turn / 2) % turn - turn / 2)
    best = int(((away <= 2 * JOINTS.step_deg) @ weights).argmax())
    near = (angles - angles[best] + turn / 2) % turn - turn / 2
    kept = np.abs(near) <= 2 * JOINTS.step_deg
    mean = float(near[kept] @ weights[kept] / weights[kept].sum())
    return float(round((angles[best] + mean) % turn, 2) % turn), int(kept.sum())
