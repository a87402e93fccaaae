"""Measure ceiling heights and windows in the photos of a house whose plan does not give them.

A photo's floor, wall and ceiling labels fit the plan well only if the ceiling height is right. The
height with the largest sum of scores over the photos wins, each at its best pose.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from plan2scene.house import FROM_PHOTOS, USUAL, House, Level
from plan2scene.parallel import each
from plan2scene.photos.locate.likelihood import log_table
from plan2scene.photos.locate.locate_photos import (
    Shot,
    labelled_openings,
    locate_shots,
    read_shots,
    view_of,
)
from plan2scene.photos.locate.locate_settings import LOCATE
from plan2scene.photos.locate.plan_view import searched_shapes
from plan2scene.photos.locate.search import HeightPrior, RoomSearch
from plan2scene.photos.locate.spots import Turned, spots_of
from plan2scene.photos.locate.which_room import WHICH
from plan2scene.plans.geometry import room_polygon
from plan2scene.plans.usual_windows import guesses_windows
from plan2scene_app.heights.seen_windows import with_seen_windows

_log = logging.getLogger("plan2scene")


@dataclass(frozen=True)
class CeilingSettings:
    """Prior of ceiling heights and constants of the search for them.

    Source: usual dwellings; nothing was chosen on homes.
    """

    #: Prior of the ceiling height: mean and standard deviation; limits of the search. Metres.
    mean_m: float = 2.5
    spread_m: float = 0.5
    limits_m: tuple[float, float] = (2.1, 4.0)
    #: Steps of the hill climb, metres, one after the other; a parabola then refines the peak.
    steps_m: tuple[float, ...] = (0.2, 0.1)
    #: Most spots that are searched, and most rooms of a spot after the first height was scored.
    spots: int = 12
    rooms: int = 4


CEILINGS = CeilingSettings()


def with_ceilings(house: House, height: float) -> House:
    """Return a house with all its ceilings at `height` metres.

    Walls end there. Openings that reached the ceiling still do, others stay below it. Upper levels
    move with the ceilings below them: slabs keep their thickness.
    """
    levels: list[Level] = []
    for level in house.levels:
        if levels:
            below = house.levels[len(levels) - 1]
            slab = level.elevation - below.elevation - below.height
            elevation = round(levels[-1].elevation + height + slab, 4)
        else:
            elevation = level.elevation
        levels.append(replace(level, elevation=elevation, height=height))
    walls = [
        replace(
            wall,
            height=height,
            openings=tuple(
                replace(opening, top=height if wall.full(opening) else min(opening.top, height))
                for opening in wall.openings
            ),
        )
        for wall in house.walls
    ]
    rooms = tuple(replace(room, height=height) for room in house.rooms)
    return replace(house, rooms=rooms, walls=tuple(walls), levels=tuple(levels))


def ceiling_height(
    house: House,
    shots: Mapping[str, Shot],
    same_spot: Turned | None = None,
    threads: int = 1,
) -> float | None:
    """Return the ceiling height that fits photos best, metres, rounded to a centimetre.

    None if no photo has a Manhattan frame. `same_spot` and `threads` are those of
    `locate_photos.locate_shots`.
    """
    rooms = {name: shot.rooms for name, shot in shots.items() if not shot.camera.fallback}
    all_spots = spots_of({name: own for name, own in rooms.items() if own}, same_spot or {})
    asked = np.unique(
        np.linspace(0, len(all_spots) - 1, min(CEILINGS.spots, len(all_spots))).round()
    )
    spots = [all_spots[int(k)] for k in asked]
    if not spots:
        return None
    table = log_table(openings=labelled_openings(shots.values()) != "nothing")
    views = [
        [view_of(shots[name], table, quarters) for name, quarters in spot.quarters.items()]
        for spot in spots
    ]
    left = [spot.rooms for spot in spots]

    def scores(height: float) -> list[dict[str, float]]:
        tall = with_ceilings(house, height)
        shapes = searched_shapes(tall)

        def of_spot(number: int) -> dict[str, float]:
            return {
                room: RoomSearch(
                    shapes, room, room_polygon(tall.room(room)), views[number], LOCATE.rough
                ).best_score(HeightPrior())
                for room in left[number]
            }

        return list(each(of_spot, range(len(spots)), threads))

    def log_probability(found: Sequence[Mapping[str, float]], height: float) -> float:
        off = (height - CEILINGS.mean_m) / CEILINGS.spread_m
        return WHICH.place * sum(max(item.values()) for item in found) - 0.5 * off**2

    first = scores(CEILINGS.mean_m)
    left = [tuple(sorted(found, key=lambda r: -found[r])[: CEILINGS.rooms]) for found in first]
    best = CEILINGS.mean_m
    log_by_height = {best: log_probability(first, best)}
    for step in CEILINGS.steps_m:
        while beside := [
            height
            for height in (round(best - step, 2), round(best + step, 2))
            if height not in log_by_height
            and CEILINGS.limits_m[0] <= height <= CEILINGS.limits_m[1]
        ]:
            log_by_height |= {height: log_probability(scores(height), height) for height in beside}
            best = max(log_by_height, key=lambda height: log_by_height[height])
    low, middle, high = (log_by_height.get(round(best + k * step, 2), -np.inf) for k in (-1, 0, 1))
    bend = low - 2 * middle + high
    return round(best + (step * (low - high) / (2 * bend) if -np.inf < bend < 0 else 0.0), 2)


def measure_ceilings(
    house: House,
    rooms_of_photo: Mapping[str, Sequence[str]],
    masks_dir: str | Path,
    *,
    name_hints: bool = True,
    threads: int = 1,
) -> House:
    """Return a house with the ceiling height and windows of its photos, if its plan lacks heights.

    Windows are replaced only if those of the plan are guesses. The arguments are those of
    :func:`~plan2scene.photos.locate.locate_photos.locate_photos`.
    """
    if house.heights != USUAL:
        return house
    read = read_shots(house, rooms_of_photo, masks_dir, name_hints=name_hints)
    height = ceiling_height(house, read.shots, read.spots, threads)
    if height is None:
        return house
    _log.info("ceilings at %.2f m", height)
    house = replace(with_ceilings(house, height), heights=FROM_PHOTOS)
    if not guesses_windows(house):
        return house
    located = locate_shots(house, read.shots, read.spots, read.turns, read.alike, threads)
    return with_seen_windows(house, read.shots, located.poses)
