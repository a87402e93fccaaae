"""Photos that were taken from one spot: they are located together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

#: Photos of one spot, the lesser name first, and their quarter turns of 0 to 3: by how much the
#: turn from the second one's Manhattan frame to the plan is larger than the first one's.
SameSpot = Mapping[tuple[str, str], int]


@dataclass(frozen=True)
class Spot:
    """Photos of one spot."""

    #: The turn of each photo's frame less that of the first one's, quarter turns of 0 to 3.
    quarters: Mapping[str, int]
    #: Rooms that it may lie in.
    rooms: tuple[str, ...]


def spots_of(rooms: Mapping[str, Sequence[str]], same_spot: SameSpot) -> list[Spot]:
    """Return the spots of photos, each of which may have been taken in `rooms`, in their order.

    Photos of which no room is common are not of one spot.
    """
    ties: dict[str, dict[str, int]] = {name: {} for name in rooms}
    for (one, other), quarters in same_spot.items():
        if one in ties and other in ties:
            ties[one][other], ties[other][one] = quarters, -quarters
    found: list[Spot] = []
    done: set[str] = set()
    for first in rooms:
        if first in done:
            continue
        turns, common, todo = {first: 0}, tuple(rooms[first]), [first]
        while todo:
            here = todo.pop()
            for other, quarters in sorted(ties[here].items()):
                both = tuple(room for room in common if room in rooms[other])
                if both and other not in turns and other not in done:
                    turns[other], common = (turns[here] + quarters) % 4, both
                    todo.append(other)
        done |= set(turns)
        found.append(Spot(turns, common))
    return found
