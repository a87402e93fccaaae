"""The pattern of a floor from all its views: what repeats in them at one size."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d

from plan2scene.photos.patterns.joints import (
    DISTANCES,
    JOINTS,
    MOSAICS,
    Direction,
    along,
    moved,
    next_row,
    refined,
    run_on,
    small_squares,
)
from plan2scene.photos.patterns.views import FloorView
from plan2scene.photos.patterns.zigzag import find_zigzag


@dataclass(frozen=True)
class FindSettings:
    """Constants chosen on renderings of procedural materials and by looking at real floors."""

    same_size: float = 0.1  #: log ratio by which the scale of photos of one floor may differ
    most_m2: float = 3.0  #: area from which on a larger view has no more weight
    enough_m2: float = 2.0  #: area that all views have to show for full confidence
    grain: float = 2.0  #: contrast kept along planks over that kept across them
    wood: float = 3.0  #: the same of wood at least, of any direction
    least_kept: float = 0.2  #: contrast kept along the grain of wood
    grainy: tuple[float, float] = (0.05, 0.15)  #: `plain` and `clear` of wood and multiples
    part: float = 0.7  #: score of a third or fifth of a distance, over its own, that makes it true
    part_of_mosaic: float = 0.25  #: the same of squares, whose next are like all that is so near
    plain: float = 0.16  #: score of floors without joints
    clear: float = 0.36  #: score from which on there is no doubt
    believed: float = 0.4  #: confidence under which a floor counts as plain
    usual_looks: tuple[float, float] = (0.45, 0.26)  #: shares of floors of wood and of tiles
    by_looks: float = 3.0  #: what log odds of wood over tiles by looks count
    looked: float = 3.1  #: those of floors that may be either
    #: Log odds of wood by length over width: short, long, not known.
    by_length: tuple[float, float, float] = (-1.2, 0.7, 1.2)
    seen_px: float = 5e4  #: photo pixels of a floor, of which joints are missed half the time
    usual: float = 0.9  #: worth of a width by the house's camera height, over one by its own
    located: int = 2  #: views that give a room a direction of its own
    least_length: float = 0.12  #: score of the joints across rows
    alone: float = 2.0  #: times the score of all other lengths, for which half of that is enough
    breaks: float = 0.3  #: of joints that come again, over their likeness: no rows
    fades: float = 0.25  #: likeness of joints half a metre on, over that beside: less is no row
    whole: float = 0.3  #: likeness of a floor of square tiles to itself, moved by a tile
    #: times that light lines are clearer than dark ones, where joints are light: a dark joint is
    #: bright on either side. Seen on two real flats (development), 1.0 and 2.1.
    light: float = 1.2
    square: float = 0.12  #: log ratio of the sides of square tiles
    mosaic: tuple[float, float] = (0.05, 0.1)  #: score of none, and of one without doubt
    widest_mosaic_m: float = 0.06
    least_mosaic_m: float = 0.015
    mosaic_px: float = 4.0  #: photo pixels of a square, from which on its size is sure
    zigzag_views: int = 12  #: in which slanting planks are looked for
    zigzag: tuple[float, float] = (0.06, 0.12)  #: score of none, and of one without doubt
    plank: float = 2.2  #: length over width of planks, at least
    widest_plank_m: float = 0.3


FIND = FindSettings()
NAN = float("nan")


@dataclass(frozen=True)
class FoundPattern:
    """The pattern of a floor."""

    #: ``planks``, ``tiles``, ``herringbone``, ``chevron``, ``mosaic``, ``plain``, or ``other``: it
    #: repeats, but not in rows, as a basket
    kind: str
    #: width_m, length_m: of a unit with half a joint on each side; NaN where not known (planks of
    #: many lengths)
    width_m: float = NAN
    length_m: float = NAN
    width_spread: float = NAN  #: standard deviation of the width between photos, over the width
    #: of the planks or of the tiles' longer side in the plan, from +x towards +z, [0, 180); of
    #: square tiles [0, 90). Of the columns of a herringbone or chevron. NaN where no located photo
    #: shows it.
    direction_deg: float = NAN
    offset: float = 0.0  #: shift of a row against the row before, over the length
    confidence: float = 0.0  #: probability that its kind is right
    #: what the joints are against the units: ``dark``, ``light`` or only a ``step`` of tone
    line: str = ""
    photos: tuple[str, ...] = ()  #: those that show it
    located: int = 0  #: located views that share the direction
    slant_deg: float = 0.0  #: between the units and the direction: 0 for rows


@dataclass(frozen=True)
class Reading:
    """One view's part in a pattern: its direction, its own width (metres) and what it counts."""

    view: FloorView
    direction: Direction
    width_m: float
    score: float

    @property
    def weight(self) -> float:
        """Return what it counts beside other views."""
        return self.score * _area(self.view)


def find_pattern(
    views: Sequence[FloorView], looks: tuple[float, float] | None = None
) -> tuple[FoundPattern, list[Reading]]:
    """Return the pattern of the floor that views show, and what each view says of it.

    `looks` is how probably the floor is of wood, and of tiles, by its looks, where that is known.
    With the length of units they part planks from tiles. Plain where no joints are evident: how
    surely depends on what could be seen, and on the looks.
    """
    if not views:
        return FoundPattern("plain"), []
    slanting = _zigzag(views)
    if slanting is not None:
        return slanting
    mosaic = _mosaic(views, (looks or FIND.usual_looks)[1])
    if mosaic is not None:
        return mosaic, []
    grainy = _grainy(views)
    for widest in (np.inf, FIND.widest_plank_m):
        confidence, readings = _rows(views, grainy, widest)
        if not readings or confidence < FIND.believed:
            unseen = (1.0 - confidence) * _without_joints(views, sum(looks or FIND.usual_looks))
            return FoundPattern("plain", confidence=unseen), []
        width, spread = _width(readings)
        ratio, offset = _length(readings)
        if not grainy or np.isfinite(ratio) or width <= FIND.widest_plank_m:
            break  # else no wood is so wide
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
        kind, ratio, square, offset = "planks", NAN, False, 0.0  # its ends were not seen
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
    """Return how sure rows up to a width are, and what each view says of the likeliest width."""
    curves = np.array([lines_of(view) for view in views])
    weights = np.array([_area(view) for view in views]) / sum(map(_area, views))
    reach = 2 * round(100 * FIND.same_size) + 1
    single = np.array([_single(curve) for curve in curves]) * np.less_equal(DISTANCES, widest_m)
    pooled = weights @ maximum_filter1d(single, reach, axis=1)
    found = _sure(views, pooled, (FIND.plain, FIND.clear))
    if found[0] < FIND.believed and grainy:
        # Wood: joints that stain and gloss hide are those whose multiples are seen as well.
        combed = weights @ maximum_filter1d(_combed(curves), reach, axis=1)
        found = max(_sure(views, combed, FIND.grainy), found, key=lambda one: one[0])
    return found


def _wood(looks: tuple[float, float] | None, ratio: float) -> float:
    """Return how probably units in rows are of wood, by their looks and their length over width."""
    odds = np.log(FIND.usual_looks[0] / FIND.usual_looks[1])
    if looks is not None:
        odds += FIND.by_looks * np.log(max(looks[0], 1e-3) / max(looks[1], 1e-3)) - FIND.looked
    short, long, unknown = FIND.by_length
    odds += unknown if not np.isfinite(ratio) else short if ratio < FIND.plank else long
    return float(1.0 / (1.0 + np.exp(-odds)))


def _without_joints(views: Sequence[FloorView], jointed: float) -> float:
    """Return how probable it is that a floor has no joints whose views show none."""
    pixels = sum(view.square_m * view.px_per_m**2 for view in views)
    missed = FIND.seen_px / (FIND.seen_px + pixels)
    return (1.0 - jointed) / (1.0 - jointed + jointed * missed)


def _mosaic(views: Sequence[FloorView], tiled: float) -> FoundPattern | None:
    """Return the mosaic that views show; None where there is none.

    `tiled` is how probably the floor is of tiles: carpets and parquet have small squares, too.
    """
    weights = np.array([_area(view) for view in views])
    if _grainy(views):
        return None
    scores = np.array([small_squares(view.directions[0].view) for view in views])
    reach = 2 * round(100 * FIND.same_size) + 1
    pooled = weights @ maximum_filter1d(scores, reach, axis=1) / weights.sum()
    none, sure = FIND.mosaic
    confidence = tiled * float(np.clip((pooled.max() - none) / (sure - none), 0.0, 1.0))
    if confidence < FIND.believed:
        return None
    # Lines of both directions part halfway: a diagonal scores twice as much as a side, and as much
    # as that of three squares, or of three beside one.
    k = int(pooled.argmax())
    for times in (3.0, np.sqrt(5.0)):
        middle = int(pooled.argmax()) - round(100 * np.log(times))
        near = pooled[max(middle - 3, 0) : max(middle + 4, 0)]
        if near.size and near.max() >= FIND.part_of_mosaic * pooled.max():
            k = max(middle - 3, 0) + int(near.argmax())
    near = np.where(np.abs(np.arange(scores.shape[1]) - k) <= reach // 2, scores, 0.0)
    shown = near.max(axis=1) > 0.0
    sizes = MOSAICS[near.argmax(axis=1)][shown] / np.sqrt(2)
    side, spread = _middle(list(sizes), list(weights[shown]))
    if side > FIND.widest_mosaic_m:
        return None
    photos = dict.fromkeys(v.photo for v, seen in zip(views, shown, strict=True) if seen)
    # Squares that a photo hardly has pixels for may be several of smaller ones.
    pixels = float(np.average([v.px_per_m for v in views], weights=weights * shown)) * side
    part = np.sqrt(5.0) if side > np.sqrt(5.0) * FIND.least_mosaic_m else 1.0
    confidence *= min(1.0, pixels / part / FIND.mosaic_px)
    return FoundPattern("mosaic", side, side, spread, confidence=confidence, photos=tuple(photos))


def _zigzag(views: Sequence[FloorView]) -> tuple[FoundPattern, list[Reading]] | None:
    """Return the herringbone or chevron that the largest views show; None where there is none."""
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
    """Return what a view counts: its area, square metres, up to a limit."""
    return min(view.square_m, FIND.most_m2)


def lines_of(view: FloorView) -> np.ndarray:
    """Return how clearly lines of a view repeat (n,) at each of `DISTANCES`, 0..2."""
    return np.asarray(np.max([direction.scores for direction in _likely(view)], axis=0))


def _likely(view: FloorView) -> list[Direction]:
    """Return the directions that long joints may have: grain leaves only one."""
    first, second = view.directions
    return [first] if first.kept > FIND.grain * second.kept else [first, second]


def _sure(
    views: Sequence[FloorView], pooled: np.ndarray, scores: tuple[float, float]
) -> tuple[float, list[Reading]]:
    """Return how sure joints at the best distance are, and what each view says of them.

    `pooled` (n,) are the scores of all views, `scores` those of none and of joints beyond doubt.
    """
    (none, clear), k = scores, int(pooled.argmax())
    readings = [_read(view, float(DISTANCES[k])) for view in views]
    readings = [r for r in readings if r.score >= 0.5 * none]
    shown = min(sum(r.view.square_m for r in readings) / FIND.enough_m2, 1.0)
    sure = shown * (pooled[k] - none) / (clear - none)  # clear joints make up for little floor
    return float(np.clip(sure, 0.0, 1.0)), readings


def _grainy(views: Sequence[FloorView]) -> bool:
    """Return whether contrast is that of wood: kept along one direction, lost across it."""
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
    """Return scores (n,) of a view's distances, 0 at what are multiples of another.

    The likeness at an odd multiple of a period is as high as at the period.
    """
    near, single = maximum_filter1d(scores, 13), scores.copy()
    for times in (3.0, 5.0):
        shift = round(100 * np.log(times))
        single[shift:][near[:-shift] >= FIND.part * scores[shift:]] = 0.0
    return single


def _read(view: FloorView, width_m: float) -> Reading:
    """Return what a view says of joints about `width_m` apart."""
    options = [(d, *d.near(width_m, 2 * FIND.same_size)) for d in _likely(view)]
    direction, width, score = max(options, key=lambda option: option[2])
    return Reading(view, direction, width, score)


def _turned(reading: Reading, ratio: float) -> Reading:
    """Return a reading by the lines across, whose distance is `ratio` times the other."""
    first, second = reading.view.directions
    other = second if reading.direction is first else first
    return Reading(reading.view, other, reading.width_m * ratio, reading.score)


def _length(readings: Sequence[Reading]) -> tuple[float, float]:
    """Return length over width (NaN where nothing repeats) and the offset of the next row."""
    weights = np.array([r.weight for r in readings])
    kinds = [along(r.direction.view, r.width_m) for r in readings]
    curves = [np.max(list(found.values()), axis=0) for found in kinds]
    shifts = [round(100 * np.log(r.width_m / 0.1)) for r in readings]
    # Over the width the lengths agree whatever the scale of a photo.
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
        own = refined(curve, low + int(curve[low:high].argmax()))
        line = max(found, key=lambda name: found[name][low:high].max())
        lengths.append(own / r.width_m)
        offsets.append(next_row(r.direction.view, r.width_m, own, line))
        counts.append(r.weight * float(curve[low:high].max()))
    if not lengths:
        return ratio, 0.0
    turn = np.exp(2j * np.pi * np.array(offsets)) @ np.array(counts)
    return _middle(lengths, counts)[0], float(np.angle(turn) / (2 * np.pi) % 1.0)


def _in_rows(readings: Sequence[Reading], line: str) -> bool:
    """Return whether joints run on through the floor, so that its units lie in rows."""
    curves = np.array([run_on(r.direction.view, r.width_m, line) for r in readings])
    weights = np.array([[r.weight] for r in readings]) * np.isfinite(curves)
    total = weights.sum(axis=0)
    seen = int(np.argmin(np.r_[total > 0.3 * total[0], False]))
    if seen < 10:
        return True
    mean = (np.nan_to_num(curves) * weights).sum(axis=0)[:seen] / total[:seen]
    smooth = np.convolve(mean, np.full(5, 0.2), "valid") / max(float(mean[:12].mean()), 1e-6)
    again = float((smooth - np.minimum.accumulate(smooth)).max())
    return again <= FIND.breaks and float(smooth[35:55].mean() if seen > 50 else 1.0) > FIND.fades


def _repeats_whole(readings: Sequence[Reading]) -> bool:
    """Return whether a floor of squares moved by one both ways is like itself.

    One of tiles is, though veins hide their joints; one of a basket's boards is not.
    """
    alike = [moved(r.direction.view, r.width_m) for r in readings]
    return bool(np.average(alike, weights=[r.weight for r in readings]) >= FIND.whole)


def _line(readings: Sequence[Reading]) -> str:
    """Return the kind of line that shows the joints best."""
    worth: dict[str, float] = {}
    for r in readings:
        k = int(np.abs(DISTANCES - r.width_m).argmin())
        for name, scores in r.direction.lines.items():
            worth[name] = worth.get(name, 0.0) + r.weight * float(
                scores[max(k - 3, 0) : k + 4].max()
            )
    if worth["light"] < FIND.light * worth["dark"]:
        worth["light"] = 0.0
    return max(worth, key=lambda name: worth[name])


def _middle(values: Sequence[float], weights: Sequence[float]) -> tuple[float, float]:
    """Return the mean of positive values near their weighted median, and all values' spread."""
    order = np.argsort(values)
    ordered, heavy = np.log(np.array(values)[order]), np.array(weights)[order]
    middle = ordered[np.searchsorted(np.cumsum(heavy), 0.5 * heavy.sum())]
    heavy = heavy / heavy.sum()
    spread = float(np.sqrt(heavy @ (ordered - middle) ** 2))
    near = heavy * (np.abs(ordered - middle) <= FIND.same_size)
    return float(np.exp(near @ ordered / near.sum())), spread


def _width(readings: Sequence[Reading]) -> tuple[float, float]:
    """Return the width that views agree on, and its spread.

    Each says it by its own scale and, a little less, by the house's usual camera height.
    """
    widths = [r.width_m * scale for r in readings for scale in (1.0, r.view.usual)]
    weights = [r.weight * worth for r in readings for worth in (1.0, FIND.usual)]
    return _middle(widths, weights)


def _direction(readings: Sequence[Reading], turn: float) -> tuple[float, int]:
    """Return the direction in the plan modulo `turn` degrees that most located views share.

    And how many do; NaN where there is none.
    """
    found = [(r.direction.angle_deg % turn, r.weight) for r in readings if r.view.in_plan]
    if not found:
        return NAN, 0
    angles, weights = (np.array(column) for column in zip(*found, strict=True))
    away = np.abs((angles[:, None] - angles + turn / 2) % turn - turn / 2)
    best = int(((away <= 2 * JOINTS.step_deg) @ weights).argmax())
    near = (angles - angles[best] + turn / 2) % turn - turn / 2
    kept = np.abs(near) <= 2 * JOINTS.step_deg
    mean = float(near[kept] @ weights[kept] / weights[kept].sum())
    return float(round((angles[best] + mean) % turn, 2) % turn), int(kept.sum())
