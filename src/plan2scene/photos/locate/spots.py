"""Photos that were taken from one spot, or see the same things: they are located together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from plan2scene.photos.locate.search import Hypothesis

#: Photos of one spot or of the same things, the lesser name first, and their quarter turns of 0 to
#: 3: by how much the turn from the second one's Manhattan frame to the plan is larger than the
#: first one's.
Turned = Mapping[tuple[str, str], int]


@dataclass(frozen=True)
class Spot:
    """Photos of one spot."""

    #: The turn of each photo's frame less that of the first one's, quarter turns of 0 to 3.
    quarters: Mapping[str, int]
    #: Rooms that it may lie in.
    rooms: tuple[str, ...]


def spots_of(rooms: Mapping[str, Sequence[str]], same_spot: Turned) -> list[Spot]:
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


def with_common_headings(
    spots: Sequence[Spot], hypotheses: Sequence[Sequence[Hypothesis]], turned: Turned
) -> list[list[Hypothesis]]:
    """Return the poses of each spot, best first, scored by what all spots say that are `turned`.

    A heading counts by the best poses of all spots at it, as if they were photos of one spot:
    their sum over the root of their number. Rooms and positions at a heading keep their leads.
    """
    spot_of = {name: number for number, spot in enumerate(spots) for name in spot.quarters}
    ties: list[list[tuple[int, int]]] = [[] for _ in spots]
    for (one, other), quarters in turned.items():
        a, b = spot_of.get(one), spot_of.get(other)
        if a is not None and b is not None and a != b:
            more = quarters + spots[a].quarters[one] - spots[b].quarters[other]
            ties[a].append((b, more))
            ties[b].append((a, -more))
    found = [list(poses) for poses in hypotheses]
    done: set[int] = set()
    for first in range(len(spots)):
        if first in done or not ties[first]:
            continue
        turns, todo = {first: 0}, [first]
        while todo:
            here = todo.pop()
            for beside, more in ties[here]:
                if beside not in turns:
                    turns[beside] = turns[here] + more
                    todo.append(beside)
        done |= set(turns)
        start = hypotheses[first][0].turn
        best = {
            number: [
                max(
                    (p.score for p in hypotheses[number] if _heading(p, start, more) == k),
                    default=-9,
                )
                for k in range(4)
            ]
            for number, more in turns.items()
        }
        total = np.sum(list(best.values()), axis=0) / np.sqrt(len(turns))
        for number, more in turns.items():
            poses = []
            for pose in hypotheses[number]:
                k = _heading(pose, start, more)
                poses.append(replace(pose, score=pose.score - best[number][k] + float(total[k])))
            found[number] = sorted(poses, key=lambda pose: -pose.score)
    return found


def _heading(pose: Hypothesis, start: float, more: int) -> int:
    """Return the quarter turns, 0 to 3, from `start` to a pose's turn less `more` of them."""
    return int(np.round((pose.turn - start) / (np.pi / 2) - more)) % 4
