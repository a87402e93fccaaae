"""What the traced rooms are: their names as written, their types, their ids."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from shapely.geometry import Point, Polygon

from plan2scene.plans.names import room_types
from plan2scene_app.plan_formats.drawing import free_id
from plan2scene_app.tracing.labels import LABEL_OF_TYPE, ROOM
from plan2scene_app.tracing.lettering import TextLine
from plan2scene_app.tracing.measures import read_area, read_length, read_sides
from plan2scene_app.tracing.openings import TracedOpening
from plan2scene_app.tracing.regions import Regions

#: Share of a room's pixels that furniture must say one kind of for the type to be told by it.
TOLD = 0.55
_OPEN_AIR = ("Balcony", "Terrace", "Outdoor")


@dataclass(frozen=True)
class TracedRoom:
    """A room in pixels of the frame."""

    number: int  #: in the regions
    polygon: Polygon
    id: str
    name: str  #: as written, empty for none
    types: tuple[str, ...]
    named: bool  #: whether what is written tells the types
    confidence: float  #: mean probability of room over its floor
    texts: tuple[TextLine, ...]


def describe_rooms(
    regions: Regions,
    polygons: dict[int, Polygon],
    probabilities: np.ndarray,
    lines: Sequence[TextLine],
) -> list[TracedRoom]:
    """Return the rooms with names and types; `lines` of text are in the frame's pixels."""
    found: list[TracedRoom] = []
    taken: set[str] = set()
    for number, polygon in polygons.items():
        own = tuple(line for line in lines if polygon.contains(Point(line.middle)))
        name = " ".join(line.text for line in own if _is_name(line.text))[:60]
        types = room_types(_words(own))
        floor = regions.floors == number
        inside = probabilities[:, floor].mean(1)
        told = types or _types_by_furniture(inside)
        base = name if types else told[0]
        sure = float(inside[ROOM:].sum())
        identifier = free_id(base, taken)
        found.append(TracedRoom(number, polygon, identifier, name, told, bool(types), sure, own))
    return found


def without_inner_windows(
    openings: Sequence[TracedOpening], rooms: Sequence[TracedRoom], widest: float
) -> list[TracedOpening]:
    """Return openings with windows between two rooms indoors as what leads from one to the other.

    A gap with nothing drawn in it looks like a window. Up to `widest` pixels it is a door, else a
    passage; neither is sure.
    """
    indoors = {room.number for room in rooms if not set(room.types) & set(_OPEN_AIR)}
    found = []
    for opening in openings:
        if opening.kind == "window" and {opening.room, opening.other} <= indoors:
            kind = "door" if opening.width <= widest else "passage"
            sure = min(opening.confidence, 0.5)
            opening = replace(opening, kind=kind, confidence=sure)
        found.append(opening)
    return found


def _words(lines: Sequence[TextLine]) -> str:
    """Return what names a room: each line alone, joined as an open plan's names are."""
    return " / ".join(line.text for line in lines if _is_name(line.text))


def _is_name(text: str) -> bool:
    """Return whether a line holds a word and no measure."""
    if read_area(text) or read_length(text) or read_sides(text):
        return False
    return bool(re.search(r"[^\W\d_]{2,}", text))


def _types_by_furniture(inside: np.ndarray) -> tuple[str, ...]:
    """Return the type that what stands in a room tells, else Unknown."""
    kinds = inside[ROOM:]
    best = int(kinds.argmax())
    if best == 0 or kinds[best] < TOLD * kinds.sum():
        return ("Unknown",)
    return (next(name for name, label in LABEL_OF_TYPE.items() if label == ROOM + best),)
