"""The places stage: masks and plan of a house -> cameras.json and photo_rooms.json.

Photos of one spot are located together. If the photo table does not give their room, a rough search
scores every room first. A fine search then runs in the known or most probable room, and again with
the camera height that the spots share.
"""

from __future__ import annotations

import csv
import logging
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np

from plan2scene.camera import Camera
from plan2scene.errors import InputError
from plan2scene.house import House
from plan2scene.io import atomic_path, write_json
from plan2scene.parallel import each
from plan2scene.photos.labels.palette import (
    AMODAL,
    DOOR,
    KINDS_FILE,
    LIKENESS_FILE,
    OTHER,
    PROBABILITIES,
    SPOTS_FILE,
    TURNS_FILE,
    read_label_png,
    read_probability_png,
)
from plan2scene.photos.locate.likelihood import OPENING, Profile, log_table, make_profile
from plan2scene.photos.locate.locate_settings import LOCATE, Grid
from plan2scene.photos.locate.plan_view import room_shapes, searched_shapes
from plan2scene.photos.locate.pose import Pose, pose_to_json, turned
from plan2scene.photos.locate.search import HeightPrior, Hypothesis, RoomSearch, View
from plan2scene.photos.locate.seen_planes import shows_its_room
from plan2scene.photos.locate.spots import Spot, Turned, spots_of, with_common_headings
from plan2scene.photos.locate.which_room import (
    NOWHERE,
    WHICH,
    PhotoEvidence,
    fitting_rooms,
    likely_room,
    room_probabilities,
    used_photos,
)
from plan2scene.plans.geometry import room_polygon
from plan2scene.stage_json import read_stage_json

_log = logging.getLogger("plan2scene")


@dataclass(frozen=True)
class Shot:
    """A photo to locate: its camera, its labels, and the rooms that it may have been taken in."""

    camera: Camera
    #: (h, w) uint8, of the camera's size: labels of `likelihood`; other values are ignored.
    labels: np.ndarray
    rooms: tuple[str, ...]
    #: (6, h', w') float32 over the same view: probability of each label; None if unknown.
    probabilities: np.ndarray | None = None
    #: Other evidence of the room; None if the photo table gives the room.
    hints: PhotoEvidence | None = None
    #: Like `probabilities`, for what the photo would show without furniture; None if unknown.
    amodal: np.ndarray | None = None

    @property
    def structure(self) -> np.ndarray | None:
        """Probabilities (6, h', w') by which a photo is located; None if they are unknown.

        They are those of the visible labels; that of other, which furniture has, is divided among
        the labels as the amodal ones are. So empty rooms are located by what photos show.
        """
        if self.probabilities is None or self.amodal is None:
            return self.probabilities
        size = self.probabilities.shape[:0:-1]
        behind = np.stack([cv2.resize(part, size) for part in self.amodal])
        shown = self.probabilities.copy()
        shown[OTHER] = 0
        return np.asarray(shown + self.probabilities[OTHER] * behind / behind.sum(axis=0))


@dataclass(frozen=True)
class Shots:
    """The photos of a house, as read from its masks folder."""

    shots: dict[str, Shot]
    #: Pairs of photos that see the same things, and pairs from one spot (`spots.Turned`).
    turns: dict[tuple[str, str], int]
    spots: dict[tuple[str, str], int]
    #: How alike photos look (`matches.likeness`).
    alike: dict[tuple[str, str], float]
    #: Cameras of all photos of the folder.
    cameras: dict[str, Camera]


@dataclass(frozen=True)
class Located:
    """Where the photos of a house were taken."""

    #: The best pose of each photo that has a Manhattan frame and a room, with its probability.
    poses: dict[str, Pose]
    #: Probability of each room, or of none (`which_room.NOWHERE`), for photos without a known room.
    rooms: dict[str, dict[str, float]]


def locate_shots(
    house: House,
    shots: Mapping[str, Shot],
    same_spot: Turned | None = None,
    same_things: Turned | None = None,
    alike: Mapping[tuple[str, str], float] | None = None,
    threads: int = 1,
) -> Located:
    """Return the rooms of photos and their poses in them.

    Photos from the `same_spot` are located together. Photos of the `same_things` share the evidence
    for their headings. Photos that look `alike` (`matches.likeness`) are more probably of one room.
    `threads` spots are searched at a time; the result does not depend on it.
    """
    shapes = room_shapes(house)
    searched_in = searched_shapes(house)
    openings = labelled_openings(shots.values())
    table = log_table(openings=openings != "nothing")

    def searches(spot: Spot, grid: Grid) -> list[RoomSearch]:
        views = [view_of(shots[name], table, quarters) for name, quarters in spot.quarters.items()]
        return [
            RoomSearch(searched_in, room_id, room_polygon(house.room(room_id)), views, grid)
            for room_id in spot.rooms
        ]

    def rough(spot: Spot) -> dict[str, float]:
        found = searches(spot, LOCATE.rough)
        return {search.room_id: search.best_score(HeightPrior()) for search in found}

    framed = [name for name, shot in shots.items() if shot.rooms and not shot.camera.fallback]
    anywhere = {name: shots[name].rooms for name in framed if shots[name].hints is not None}
    groups = spots_of(anywhere, same_spot or {})
    scores = {
        name: every
        for spot, every in zip(groups, each(rough, groups, threads), strict=True)
        for name in spot.quarters
    }
    tied = {**(same_spot or {}), **(same_things or {})}
    rooms = _rooms(house, shots, scores, tied, alike or {})
    likely = {name: likely_room(house, every) for name, every in rooms.items()}
    listed_rooms = {room for name in framed if name not in likely for room in shots[name].rooms}
    used = used_photos(likely, listed_rooms)
    rooms_to_search = {
        name: shots[name].rooms if name not in likely else (likely[name].room_id,)
        for name in framed
        if name not in likely or name in used
    }

    def search(spot: Spot) -> tuple[list[RoomSearch], list[Hypothesis]]:
        found = searches(spot, LOCATE.grid)
        return found, _best(found, HeightPrior())

    spots = spots_of(rooms_to_search, same_spot or {})
    searched = list(each(search, spots, threads))
    hypotheses = with_common_headings(spots, [poses for _, poses in searched], tied)
    prior = shared_height(hypotheses)
    if prior is not None:
        again = list(each(lambda found: _best(found, prior), (s for s, _ in searched), threads))
        hypotheses = with_common_headings(spots, again, tied)
    poses = {}
    for spot, every in zip(spots, hypotheses, strict=True):
        best, found = every[0], probability(every, openings)
        for name, quarters in spot.quarters.items():
            sure = rooms[name][best.room_id] if name in rooms else 1.0
            camera = turned(shots[name].camera, best.turn + quarters * np.pi / 2)
            pose = Pose(best.room_id, best.position, camera, sure * found)
            if pose.believed and not shows_its_room(shots[name].labels, pose, shapes):
                pose = replace(pose, located=0.0)
            poses[name] = pose
    return Located(poses, rooms)


def _rooms(
    house: House,
    shots: Mapping[str, Shot],
    scores: Mapping[str, Mapping[str, float]],
    tied: Turned,
    alike: Mapping[tuple[str, str], float],
) -> dict[str, dict[str, float]]:
    """Return the probability of each room for the photos without a room in the photo table."""
    evidence = {
        name: PhotoEvidence(told=shot.rooms)
        if shot.hints is None
        else replace(shot.hints, scores=scores.get(name, {}))
        for name, shot in shots.items()
    }
    if all(item.told for item in evidence.values()):
        return {}
    probabilities = room_probabilities(house, evidence, tied, alike)
    return {name: rooms for name, rooms in probabilities.items() if not evidence[name].told}


def labelled_openings(shots: Iterable[Shot]) -> str:
    """Return how masks mark doors and windows: a key of `LocateSettings.less_sure`."""
    every = list(shots)
    if any(shot.probabilities is not None for shot in every):
        return "probabilities"
    drawn = (((shot.labels >= DOOR) & (shot.labels <= OPENING)).any() for shot in every)
    return "labels" if any(drawn) else "nothing"


def shared_height(hypotheses: Sequence[Sequence[Hypothesis]]) -> HeightPrior | None:
    """Return a camera height prior from the spots (poses, best first) that are clearly located."""
    clear = [
        poses[0].position[1] for poses in hypotheses if margins(poses)[0] >= LOCATE.clear_margin
    ]
    if len(clear) < LOCATE.min_clear:
        return None
    middle = float(np.median(clear))
    spread = 1.5 * float(np.median(np.abs(np.array(clear) - middle)))
    return HeightPrior(middle, max(spread, LOCATE.min_spread_m))


def margins(poses: Sequence[Hypothesis]) -> tuple[float, float]:
    """Return the leads in score of the first pose over the others, each at most 1.

    The first is the lead over poses with another heading or room, the second over poses with the
    same heading and room at another position (`LOCATE.elsewhere_m`).
    """
    best = poses[0]
    heading = elsewhere = 1.0
    for pose in poses[1:]:
        lead = best.score - pose.score
        off = np.angle(np.exp(1j * (pose.turn - best.turn)))
        if pose.room_id != best.room_id or abs(off) > np.pi / 4:
            heading = min(heading, lead)
        elif np.hypot(*(np.array(pose.position) - best.position)[[0, 2]]) > LOCATE.elsewhere_m:
            elsewhere = min(elsewhere, lead)
    return heading, elsewhere


def _best(searches: Sequence[RoomSearch], prior: HeightPrior) -> list[Hypothesis]:
    """Return the poses in all rooms, the best first."""
    hypotheses = [pose for search in searches for pose in search.best(prior)]
    return sorted(hypotheses, key=lambda pose: -pose.score)


def view_of(shot: Shot, table: np.ndarray, quarters: int) -> View:
    """Return a photo's profiles; `table` is that of `log_table`, `quarters` those of `Spot`."""
    structure = shot.structure

    def profile(blur: float) -> Profile:
        return make_profile(shot.labels, shot.camera, table, blur, structure)

    return View(profile(LOCATE.coarse_blur), profile(LOCATE.fine_blur), quarters)


def probability(poses: Sequence[Hypothesis], openings: str) -> float:
    """Return the probability that heading and position of the first pose are right.

    `openings` is the result of :func:`labelled_openings`.
    """
    leads = np.log10(np.maximum(margins(poses), 0.0) + LOCATE.lead_floor)
    rooms = len({pose.room_id for pose in poses})
    logit = LOCATE.weights[0] + float(leads @ np.array(LOCATE.weights[1:]))
    logit -= LOCATE.less_sure[openings] + LOCATE.more_rooms * float(np.log(rooms))
    return float(1.0 / (1.0 + np.exp(-logit)))


def locate_photos(
    house: House,
    rooms_of_photo: Mapping[str, Sequence[str]],
    masks_dir: str | Path,
    output: str | Path,
    *,
    name_hints: bool = True,
    threads: int = 1,
) -> Located:
    """Write a house's cameras.json; return the photos' poses and the probabilities of their rooms.

    `rooms_of_photo` are the rooms that each photo shows; it was taken in one of them, or in any
    room of the house if none is named. `masks_dir` is the output of the masks stage. Its cameras
    and their places in the plan are written to `output` (``docs/conventions.md``). With
    `name_hints` a photo's name is evidence of its room. `threads` spots are searched at a time; the
    result does not depend on it.
    """
    read = read_shots(house, rooms_of_photo, masks_dir, name_hints=name_hints)
    located = locate_shots(house, read.shots, read.spots, read.turns, read.alike, threads)
    entries = {}
    for name in sorted(read.cameras):
        entries[name] = pose_to_json(read.cameras[name], located.poses.get(name))
        if name in located.rooms:
            entries[name] |= {"rooms": located.rooms[name]}
    write_json(output, entries)
    count = sum(pose.believed for pose in located.poses.values())
    _log.info("%d of %d photos located", count, len(read.cameras))
    return located


def read_shots(
    house: House,
    rooms_of_photo: Mapping[str, Sequence[str]],
    masks_dir: str | Path,
    *,
    name_hints: bool = True,
) -> Shots:
    """Read the photos of a masks folder that are in `rooms_of_photo`; see :func:`locate_photos`."""
    folder = Path(masks_dir)
    file = folder / "cameras.json"
    cameras = {
        name: Camera.from_json(value, file=file)
        for name, value in read_stage_json(file, "cameras").items()
    }
    kinds = read_stage_json(folder / KINDS_FILE, "kinds")
    anywhere = [room.id for room in house.rooms]
    shots: dict[str, Shot] = {}
    for name in sorted(cameras.keys() & rooms_of_photo.keys()):
        stem, hints = Path(name).stem, None
        if not rooms_of_photo[name]:
            kind = kinds["photos"].get(name)
            named = fitting_rooms(house, stem) if name_hints else {}
            hints = PhotoEvidence(kinds=np.array(kind) if kind else None, named=named)
        likely = [
            read_probability_png(path, house_id=house.id) if path.exists() else None
            for path in (folder / of / f"{stem}.png" for of in (PROBABILITIES, AMODAL))
        ]
        shots[name] = Shot(
            cameras[name],
            read_label_png(folder / f"{stem}.png", house_id=house.id, openings=True),
            tuple(dict.fromkeys(rooms_of_photo[name] or anywhere)),
            likely[0],
            hints,
            likely[1],
        )
    turns, spots = (
        {(a, b): int(quarters) for a, b, quarters in read_stage_json(folder / file, "spots")}
        for file in (TURNS_FILE, SPOTS_FILE)
    )
    alike = {(a, b): v for a, b, v in read_stage_json(folder / LIKENESS_FILE, "likeness")}
    return Shots(shots, turns, spots, alike, cameras)


def write_photo_rooms(
    house: House,
    rooms_of_photo: Mapping[str, Sequence[str]],
    cameras: str | Path | None,
    output: str | Path,
    table: str | Path,
) -> dict[str, list[str]]:
    """Write photo_rooms.json and return it: photo -> the rooms that it shows.

    These are the rooms of the photo table; for a photo without any, they are its most probable one.
    `cameras` is the cameras.json of `locate_photos`, None if photos have no camera. A photo without
    a room, or with a guess that is not used, is left out; one log line names all such photos.
    `table` is a second output: a photo table of these rooms and of the photos without a room, with
    the probability of the room and of its kind, and the guesses.
    """
    camera_entries = {} if cameras is None else read_stage_json(cameras, "cameras", house=house)
    probabilities = {
        name: entry["rooms"] for name, entry in camera_entries.items() if "rooms" in entry
    }
    likely = {
        photo: likely_room(house, probabilities.get(photo, {NOWHERE: 1.0}))
        for photo, named in rooms_of_photo.items()
        if not named
    }
    used = used_photos(likely, {room for named in rooms_of_photo.values() for room in named})
    rooms = {
        photo: list(named) or [likely[photo].room_id] * (photo in used)
        for photo, named in rooms_of_photo.items()
    }
    left_out = sorted(
        photo
        for photo, named in rooms.items()
        if not named and (cameras is None or photo in camera_entries)
    )
    if left_out:
        expected = "a room_id in the photo table where a photo's place in the plan is not clear"
        line = InputError(expected, "none", house=house.id)
        _log.warning("%s for %s; left out", line, ", ".join(left_out))
    rows = []
    for photo, named in rooms.items():
        if photo in likely:
            room, sure, of_kind = likely[photo]
            guess = room if sure < WHICH.least else ""
            probability_cells = [f"{sure:.2f}", f"{of_kind:.2f}"] if room else ["", ""]
            rows.append([room, photo, *probability_cells, guess])
        else:
            rows += [[room, photo, "", "", ""] for room in named]
    header = ["room_id", "photo", "probability", "of_kind", "guess"]
    with atomic_path(table) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([header, *rows])
    rooms = {photo: named for photo, named in rooms.items() if named}
    write_json(output, rooms)
    return rooms
