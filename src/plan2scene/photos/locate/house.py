"""All photos of a house in its plan: each searched alone, then under the height they share."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from plan2scene.camera import Camera
from plan2scene.house import House
from plan2scene.parallel import each
from plan2scene.photos.labels.palette import DOOR
from plan2scene.photos.locate.confidence import Evidence, probability
from plan2scene.photos.locate.likelihood import OPENING, log_table
from plan2scene.photos.locate.plan_view import room_shapes
from plan2scene.photos.locate.pose import Pose, turned
from plan2scene.photos.locate.profile import make_profile
from plan2scene.photos.locate.search import Found, HeightPrior, RoomSearch
from plan2scene.plans.geometry import room_polygon

#: Blur of the coarse and the fine search, radians: what plan and frame are uncertain by.
COARSE_BLUR, FINE_BLUR = np.radians(3.0), np.radians(1.0)
#: Photos whose headings differ in score by this tell the height of the others, ...
CLEAR_MARGIN = 0.04
#: ... where there are so many; least spread of the heights, metres.
MIN_CLEAR = 3
MIN_SPREAD_M = 0.06
#: Another position is one so far away, metres; headings differ by more than 45 degrees.
ELSEWHERE_M = 1.0


@dataclass(frozen=True)
class Shot:
    """A photo to locate: its camera, its labels, and the rooms that it may have been taken in."""

    camera: Camera
    #: (h, w) uint8, the camera's size: labels of `likelihood`; others say nothing.
    labels: np.ndarray
    rooms: tuple[str, ...]
    #: (6, h', w') float32 over the same view: how likely each label is, where that is known.
    probabilities: np.ndarray | None = None


def locate_shots(house: House, shots: Mapping[str, Shot], threads: int = 1) -> dict[str, Pose]:
    """Return the best pose of each photo that has a frame and a room, with its probability.

    `threads` photos are searched at a time; the result does not depend on it.
    """
    shapes = room_shapes(house)
    told = openings_told(shots.values())
    table = log_table(told)

    def search(shot: Shot) -> tuple[list[RoomSearch], list[Found]]:
        coarse, fine = (
            make_profile(shot.labels, shot.camera, table, blur, shot.probabilities)
            for blur in (COARSE_BLUR, FINE_BLUR)
        )
        rooms = [
            RoomSearch(shapes, room_id, room_polygon(house.room(room_id)), coarse, fine)
            for room_id in shot.rooms
        ]
        return rooms, _best(rooms, HeightPrior())

    names = [name for name, shot in shots.items() if shot.rooms and not shot.camera.fallback]
    searched = list(each(search, [shots[name] for name in names], threads))
    found = [poses for _, poses in searched]
    prior = shared_height([poses for poses in found if poses])
    if prior is not None:
        found = list(each(lambda rooms: _best(rooms, prior), (s for s, _ in searched), threads))
    return {
        name: _pose(shots[name], poses, told)
        for name, poses in zip(names, found, strict=True)
        if poses
    }


def openings_told(shots: Iterable[Shot]) -> str:
    """Return which openings the masks of a house tell, of `likelihood.TOLD`."""
    given = list(shots)
    if any(shot.probabilities is not None for shot in given):
        return "windows"
    drawn = (((shot.labels >= DOOR) & (shot.labels <= OPENING)).any() for shot in given)
    return "all" if any(drawn) else "nothing"


def shared_height(found: Sequence[Sequence[Found]]) -> HeightPrior | None:
    """Return what clearly located photos (the best pose of each first) tell of all heights."""
    clear = [poses[0].position[1] for poses in found if margins(poses)[0] >= CLEAR_MARGIN]
    if len(clear) < MIN_CLEAR:
        return None
    middle = float(np.median(clear))
    spread = 1.5 * float(np.median(np.abs(np.array(clear) - middle)))
    return HeightPrior(middle, max(spread, MIN_SPREAD_M))


def margins(poses: Sequence[Found]) -> tuple[float, float]:
    """Return by how much the first pose beats the best of another heading or room, and elsewhere.

    Elsewhere is the same heading and room at another position.
    """
    best = poses[0]
    heading = elsewhere = 1.0
    for pose in poses[1:]:
        lead = best.score - pose.score
        off = np.angle(np.exp(1j * (pose.turn - best.turn)))
        if pose.room_id != best.room_id or abs(off) > np.pi / 4:
            heading = min(heading, lead)
        elif np.hypot(*(np.array(pose.position) - best.position)[[0, 2]]) > ELSEWHERE_M:
            elsewhere = min(elsewhere, lead)
    return heading, elsewhere


def _best(searches: Sequence[RoomSearch], prior: HeightPrior) -> list[Found]:
    """Return the poses in all rooms, the best first."""
    found = [pose for search in searches for pose in search.best(prior)]
    return sorted(found, key=lambda pose: -pose.score)


def _pose(shot: Shot, poses: Sequence[Found], told: str) -> Pose:
    """Return the best of the poses and its probability."""
    best, (heading, elsewhere) = poses[0], margins(poses)
    located = probability(Evidence(heading, elsewhere, told, len(shot.rooms)))
    return Pose(best.room_id, best.position, turned(shot.camera, best.turn), located)
