"""The scale of a plan: what its texts, rooms, walls and doors agree on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from plan2scene_app.plan_formats.measures import in_two_units, read_areas, read_length, read_sides
from plan2scene_app.tracing.lettering import TextLine
from plan2scene_app.tracing.settings import SETTINGS


@dataclass(frozen=True)
class Evidence:
    """What one text says about the scale: candidate logarithms of metres a pixel; one is right."""

    text: str
    meanings: tuple[float, ...]
    deviation: float
    weight: float


@dataclass(frozen=True)
class Scale:
    """The scale of a picture."""

    metres_per_pixel: float
    confidence: float  #: 0 to 1
    source: str  #: where it comes from, in words
    agree: tuple[str, ...] = ()  #: texts that agree with it
    differ: tuple[str, ...] = ()  #: measures in rooms that do not agree


@dataclass(frozen=True)
class RoomSize:
    """A room as the picture shows it, between its walls, in pixels."""

    area: float
    sides: tuple[float, float]
    texts: Sequence[TextLine] = field(default=())


def told_area(text: str, *, feet: bool = False) -> list[float]:
    """Return the area in m2 that a text gives for its room, directly or by two sides, if any."""
    areas = [area for area, _ in read_areas(text)]
    return areas[:1] or [a * b for a, b in read_room_sides(text, feet=feet)[:1]]


def read_room_sides(text: str, *, feet: bool) -> list[tuple[float, float]]:
    """Return the pairs of sides in metres that a text may mean.

    Small numbers may be metres or feet: they are read as feet if `feet`, else as metres.
    """
    pairs = read_sides(text)
    return pairs[feet:][:1] if in_two_units(pairs) else pairs


def room_evidence(room: RoomSize, *, feet: bool = False) -> list[Evidence]:
    """Return the evidence of a room's texts, areas and sides; small sides are `feet` or metres."""
    evidence = []
    for line in room.texts:
        for area, digit in read_areas(line.text)[:1]:
            deviation = max(0.02, 0.35 * digit / area)
            meaning = 0.5 * float(np.log(area / room.area))
            evidence.append(Evidence(line.text, (meaning,), deviation, 1.0))
        meanings = []
        for a, b in read_room_sides(line.text, feet=feet):
            for first, second in ((a, b), (b, a)):
                logs = np.log([first / room.sides[0], second / room.sides[1]])
                if abs(logs[0] - logs[1]) < 0.12:
                    meanings.append(float(logs.mean()))
        if meanings:
            evidence.append(Evidence(line.text, tuple(meanings), 0.03, 1.0))
    return evidence


def chain_evidence(
    line: TextLine, lines_x: Sequence[float], lines_y: Sequence[float]
) -> Evidence | None:
    """Return the evidence of a single length, which stands in the middle between two walls.

    `lines_x` and `lines_y` are the x and y of walls, in pixels.
    """
    lengths = read_length(line.text)
    if not lengths or read_areas(line.text):
        return None
    meanings = []
    wide = line.size[0] > 1.3 * line.size[1]
    for axis, places in ((0, lines_x), (1, lines_y)):
        if (axis == 0 and line.upright) or (axis == 1 and wide):
            continue
        middle = line.middle[axis]
        spans = []
        for i, low in enumerate(places):
            for high in places[i + 1 :]:
                off = abs((low + high) / 2 - middle)
                if high - low > line.size[axis] and off < 0.03 * (high - low) + 4:
                    spans.append((off, high - low))
        for _, span in sorted(spans)[:5]:
            meanings += [float(np.log(length / span)) for length in lengths]
    return Evidence(line.text, tuple(meanings), 0.025, 0.6) if meanings else None


def find_scale(
    evidence: Sequence[Evidence], door_widths: Sequence[float], floors: Sequence[float]
) -> Scale:
    """Return the scale on which most evidence agrees.

    `door_widths` (pixels) and `floors` (pixels squared, one for each room) give a prior, and the
    scale itself if nothing is written.
    """
    prior, spread, source = _prior(door_widths, floors)
    candidates = [m for e in evidence for m in e.meanings if abs(m - prior) < 3.5 * spread]
    if not candidates:
        sure = 0.45 if len(door_widths) >= 3 else 0.3 if door_widths else 0.1
        return Scale(float(np.exp(prior)), sure, source)
    best = max(candidates, key=lambda c: _support(evidence, c) - 0.5 * ((c - prior) / spread) ** 2)
    for _ in range(3):
        inliers = [(e, m) for e in evidence if (m := _nearest(e, best)) is not None]
        weights = np.array([e.weight / e.deviation**2 for e, _ in inliers])
        best = float((weights * np.array([m for _, m in inliers])).sum() / weights.sum())
    agreed = {id(e) for e, _ in inliers}
    against = [e for e in evidence if id(e) not in agreed and e.weight >= 1]
    support = sum(e.weight for e, _ in inliers)
    sure = support / (support + 0.5 * sum(e.weight for e in against) + 0.6)
    if abs(best - prior) > 2 * spread:
        sure *= 0.7
    words = f"{len(inliers)} measures that are written agree"
    texts = (tuple(e.text for e, _ in inliers), tuple(e.text for e in against))
    return Scale(float(np.exp(best)), sure, words, *texts)


def _prior(door_widths: Sequence[float], floors: Sequence[float]) -> tuple[float, float, str]:
    """Return the prior of the scale, from doors and rooms: its logarithm, deviation and source."""
    by_rooms = 0.5 * float(np.log(SETTINGS.floor[0] / np.mean(floors)))
    if not door_widths:
        return by_rooms, SETTINGS.floor[1], f"a guess: rooms of {SETTINGS.floor[0]:g} m2"
    by_doors = float(np.log(SETTINGS.door_width[0] / np.median(door_widths)))
    weights = np.array(
        [1 / (SETTINGS.door_width[1] + 0.2 / len(door_widths)) ** 2, 1 / SETTINGS.floor[1] ** 2]
    )
    mean = float((weights * [by_doors, by_rooms]).sum() / weights.sum())
    source = f"a guess: doors of {SETTINGS.door_width[0]} m, rooms of {SETTINGS.floor[0]:g} m2"
    return mean, float(weights.sum() ** -0.5), source


def _nearest(evidence: Evidence, scale: float) -> float | None:
    """Return the meaning that is nearest to a scale (a logarithm); None if none agrees with it."""
    meaning = min(evidence.meanings, key=lambda m: abs(m - scale))
    return meaning if abs(meaning - scale) < SETTINGS.agrees * evidence.deviation else None


def _support(evidence: Sequence[Evidence], scale: float) -> float:
    """Return the weighted sum of how well all evidence agrees with a scale (a logarithm)."""
    total = 0.0
    for item in evidence:
        off = min(abs(m - scale) for m in item.meanings) / item.deviation
        total += item.weight * float(np.exp(-0.5 * off**2))
    return total
