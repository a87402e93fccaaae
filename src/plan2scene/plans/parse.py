"""Checked values from untrusted files: a fault names file, house, room, expected and found."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from plan2scene.errors import InputError
from plan2scene.house import MAX_ID_LENGTH as MAX_ID_LENGTH
from plan2scene.house import ROOM_TYPES, Point, Ring, Room

#: Ids of houses, rooms, walls and openings (they become file names).
ID_PATTERN = re.compile(r"[A-Za-z0-9_-][A-Za-z0-9_.-]*")
MAX_NAME_LENGTH = 100  #: Longest display name, in letters
MAX_COORDINATE = 1000.0  #: Largest coordinate in metres; beyond it the scale of the plan is wrong
MAX_ITEMS = 20_000  #: Largest number of entries of one list in a plan
MAX_ROOMS = 1000  #: Largest number of rooms of one house
#: Largest number of corners of all rooms, in plans whose walls are made from the outlines.
MAX_CORNERS = 5000
SAME_POINT = 1e-6  #: Points closer than this (metres) are one point
#: Raster-to-vector labels and the room type that each means.
R2V_TYPES = {
    "living_room": "Reception",
    "dining_room": "Reception",
    "kitchen": "Kitchen",
    "bedroom": "Bedroom",
    "bathroom": "Bathroom",
    "restroom": "Bathroom",
    "washing_room": "Bathroom",
    "ps": "Closet",
    "stairs": "Staircase",
    "outside": "Outdoor",
}
#: Every name of a room type that plans may use, in lower case, and the type that it means.
TYPE_NAMES = {**{name.lower(): name for name in ROOM_TYPES}, **R2V_TYPES}
_LABEL = re.compile(r"[a-z][a-z_]*")


@dataclass(frozen=True)
class Source:
    """The plan being read: where faults are, and the warnings met so far."""

    file: str
    house_id: str
    warnings: list[str] = field(default_factory=list)

    def fault(self, expected: str, found: object, room: str = "") -> InputError:
        """Return (not raise) the error of a fault in this plan."""
        return InputError(expected, str(found), file=self.file, house=self.house_id, room=room)

    def warn(self, expected: str, found: object, room: str = "") -> None:
        """Add the warning of a fault that does not stop the house; each line once."""
        line = str(self.fault(expected, found, room))
        if line not in self.warnings:
            self.warnings.append(line)

    def mapping(self, value: Any, what: str) -> dict[str, Any]:
        """Return `value` if it is a JSON object."""
        if not isinstance(value, dict):
            raise self.fault(f"an object for {what}", _kind(value))
        return value

    def items(self, value: Any, what: str) -> list[Any]:
        """Return `value` if it is a JSON list of at most `MAX_ITEMS` entries (None: empty)."""
        if value is None:
            return []
        if not isinstance(value, list):
            raise self.fault(f"a list for {what}", _kind(value))
        if len(value) > MAX_ITEMS:
            raise self.fault(f"at most {MAX_ITEMS} entries of {what}", len(value))
        return value

    def number(self, value: Any, what: str, room: str = "") -> float:
        """Return a finite float of at most `MAX_COORDINATE` metres."""
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.fault(f"a number for {what}", _kind(value), room)
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise self.fault(f"a finite number for {what}", number, room)
        if abs(number) > MAX_COORDINATE:
            expected = f"{what} within {MAX_COORDINATE:g} m (is the plan's scale in metres?)"
            raise self.fault(expected, f"{number:g}", room)
        return number

    def identifier(self, value: Any, what: str, room: str = "") -> str:
        """Return an id (a string or an integer) that may become part of a file name."""
        text = str(value) if isinstance(value, str | int) and not isinstance(value, bool) else ""
        if len(text) > MAX_ID_LENGTH or not ID_PATTERN.fullmatch(text):
            found = repr(value) if isinstance(value, str | int) else _kind(value)
            raise self.fault(f"{what} of letters, digits, '_', '-' and '.'", found, room)
        return text

    def shown_name(self, value: Any) -> str:
        """Return the display name that a file gives; empty for none."""
        text = value if isinstance(value, str) else ""
        name = " ".join(text.encode("utf-8", "replace").decode().split())[:MAX_NAME_LENGTH]
        return "".join(letter for letter in name if letter.isprintable())

    def point(self, value: Any, what: str, room: str = "") -> tuple[float, float, float]:
        """Return an [x, y, z] point as floats ([x, z] gets y = 0)."""
        if not isinstance(value, list) or len(value) not in (2, 3):
            raise self.fault(f"[x, y, z] for {what}", _kind(value), room)
        numbers = [self.number(v, f"a coordinate of {what}", room) for v in value]
        if len(numbers) == 2:
            return numbers[0], 0.0, numbers[1]
        return numbers[0], numbers[1], numbers[2]

    def ring(self, points: Iterable[Point], room: str) -> Ring:
        """Return a ring without repeated neighbours and closing point; at least 3 points."""
        kept: list[Point] = []
        for point in points:
            if not kept or math.dist(point, kept[-1]) > SAME_POINT:
                kept.append(point)
        while len(kept) > 1 and math.dist(kept[0], kept[-1]) <= SAME_POINT:
            kept.pop()
        if len(kept) < 3:
            raise self.fault("an outline of at least 3 points", f"{len(kept)} points", room)
        return tuple(kept)

    def outline(self, points: Iterable[Iterable[Any]], room: str) -> Ring:
        """Return the :meth:`ring` of [x, z] pairs as a file has them."""
        pairs = [[self.number(v, "a coordinate", room) for v in point] for point in points]
        return self.ring([(x, z) for x, z in pairs], room)

    def limit_corners(self, rooms: Iterable[Room]) -> None:
        """Raise InputError if the rooms have more than `MAX_CORNERS` corners."""
        corners = sum(len(ring) for room in rooms for ring in room.rings)
        if corners > MAX_CORNERS:
            raise self.fault(f"at most {MAX_CORNERS} corners of all rooms", corners)

    def box(self, item: dict[str, Any], what: str) -> tuple[Point, Point]:
        """Return the corners p1 and p2 (x, z) of an item's ``bound_box``."""
        box = self.mapping(item.get("bound_box"), f"{what}'s bound_box")
        corners = [self.point(box.get(name), f"{what}'s corner") for name in ("p1", "p2")]
        (x0, _, z0), (x1, _, z1) = corners
        return (x0, z0), (x1, z1)

    def room_type(self, value: Any, room: str) -> str:
        """Return one of `ROOM_TYPES` for a type of scene.json or a raster-to-vector label.

        A lower-case label that no list knows is Unknown with a warning (plans of the reference
        converter keep such labels); any other name is a fault.
        """
        known = TYPE_NAMES.get(value.lower()) if isinstance(value, str) else None
        if known is not None:
            return known
        expected = f"a room type ({', '.join(ROOM_TYPES)})"
        found = repr(value) if isinstance(value, str) else _kind(value)
        if isinstance(value, str) and _LABEL.fullmatch(value):
            self.warn(expected, f"{found}, read as Unknown", room)
            return "Unknown"
        raise self.fault(expected, found, room)


def parse_json(text: str, file: str | Path, house_id: str = "") -> Any:
    """Return parsed JSON.

    Raises InputError for a syntax error, NaN, a repeated key, deep nesting, and half a surrogate
    pair, which UTF-8 cannot encode.
    """

    def refuse(name: str) -> float:
        raise InputError("finite numbers", name, file=file, house=house_id)

    def once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        document = dict(pairs)
        if len(document) < len(pairs):
            names = [name for name, _ in pairs]
            name = next(name for name in names if names.count(name) > 1)
            raise InputError("each key of an object once", repr(name), file=file, house=house_id)
        return document

    try:
        document = json.loads(text, parse_constant=refuse, object_pairs_hook=once)
        if "\\ud" in text.lower():
            json.dumps(document, ensure_ascii=False).encode()
        return document
    except InputError:
        raise
    except RecursionError:
        raise InputError("JSON", "nesting too deep", file=file, house=house_id) from None
    except UnicodeEncodeError as error:
        half = f"\\u{ord(error.object[error.start]):04x}, half a surrogate pair"
        raise InputError("Unicode text", half, file=file, house=house_id) from None
    except ValueError as error:  # syntax errors, and integers of thousands of digits
        raise InputError("JSON", f"a syntax error ({error})", file=file, house=house_id) from None


def _kind(value: Any) -> str:
    """Return what a JSON value is, for messages."""
    if value is None:
        return "nothing"
    if isinstance(value, list):
        return f"a list of {len(value)}"
    if isinstance(value, dict):
        return f"an object of {len(value)} keys"
    return repr(value)
