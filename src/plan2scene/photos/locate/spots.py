"""Group photos that were taken from one spot or see the same things, to locate them together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from plan2scene.photos.locate.search import Hypothesis

#: Pairs of photos from one spot or of the same things, the lesser name first, with a number of
#: quarter turns, 0 to 3: the turn from the second photo's Manhattan frame to the plan minus that of
#: the first photo.
Turned = Mapping[tuple[str, str], int]


@dataclass(frozen=True)
class Spot:
    """Photos taken from one spot."""

    #: The turn of each photo's frame minus that of the first photo, quarter turns, 0 to 3.
    quarters: Mapping[str, int]
    #: Rooms that the spot may lie in.
    rooms: tuple[str, ...]


def spots_of(rooms: Mapping[str, Sequence[str]], same_spot: Turned) -> list[Spot]:
    """Group photos into spots, in the order of `rooms` (photo -> rooms it may be taken in).

    Photos without a common room are not put into one spot.
    """
    ties: dict[str, dict[str, int]] = {name: {} for name in rooms}
    for (one, other), quarters in same_spot.items():
        if one in ties and other in ties:
            ties[one][other], ties[other][one] = quarters, -quarters
    spots: list[Spot] = []
    done: set[str] = set()
    for first in rooms:
        if first in done:
            continue
        turns, common, todo = {first: 0}, tuple(rooms[first]), [first]
        while todo:
            photo = todo.pop()
            for other, quarters in sorted(ties[photo].items()):
                both = tuple(room for room in common if room in rooms[other])
                if both and other not in turns and other not in done:
                    turns[other], common = (turns[photo] + quarters) % 4, both
                    todo.append(other)
        done |= set(turns)
        spots.append(Spot(turns, common))
    return spots


def with_common_headings(
    spots: Sequence[Spot], hypotheses: Sequence[Sequence[Hypothesis]], turned: Turned
) -> list[list[Hypothesis]]:
    """Return the poses of each spot, best first, with one score of each heading for tied spots.

    Spots are tied by `turned`. The score of a heading is the sum of the best scores of all tied
    spots at it, divided by the square root of their number, as for photos of one spot. Differences
    in score between rooms and positions at one heading stay.
    """
    spot_of = {name: number for number, spot in enumerate(spots) for name in spot.quarters}
    ties: list[list[tuple[int, int]]] = [[] for _ in spots]
    for (one, other), quarters in turned.items():
        a, b = spot_of.get(one), spot_of.get(other)
        if a is not None and b is not None and a != b:
            more = quarters + spots[a].quarters[one] - spots[b].quarters[other]
            ties[a].append((b, more))
            ties[b].append((a, -more))
    ranked_poses = [list(poses) for poses in hypotheses]
    done: set[int] = set()
    for first in range(len(spots)):
        if first in done or not ties[first]:
            continue
        turns, todo = {first: 0}, [first]
        while todo:
            spot_number = todo.pop()
            for beside, more in ties[spot_number]:
                if beside not in turns:
                    turns[beside] = turns[spot_number] + more
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
            ranked_poses[number] = sorted(poses, key=lambda pose: -pose.score)
    return ranked_poses


def _heading(pose: Hypothesis, start: float, more: int) -> int:
    """Return the quarter turns from `start` to a pose's turn, minus `more`; 0 to 3."""
    return int(np.round((pose.turn - start) / (np.pi / 2) - more)) % 4
