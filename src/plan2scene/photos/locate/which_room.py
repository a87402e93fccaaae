"""Which room each photo shows: all evidence together, all photos of a home jointly.

A photo alone hardly tells its room. What counts: how well its labels agree with each room of the
plan, what the room is used for, photos that show the same things, the photo's name, and that
people photograph every main room of a home before they photograph one often.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from plan2scene.house import House, Room
from plan2scene.photos.labels.palette import KINDS
from plan2scene.plans.geometry import room_polygon
from plan2scene.plans.room_names import room_types
from plan2scene.seeds import generator

#: Room types and the kinds that photos of them look like; other types may be of any kind.
KIND_OF = {kind: kind for kind in KINDS} | {"Entrance": "Corridor", "Staircase": "Corridor"}
#: What photos of a room of a kind look like: many kitchens have a table, many bedrooms a desk.
LOOKS = {
    "Reception": {"Reception": 0.8, "Kitchen": 0.1, "Bedroom": 0.1},
    "Bedroom": {"Bedroom": 0.8, "Reception": 0.2},
    "Kitchen": {"Kitchen": 0.65, "Reception": 0.35},
    "Bathroom": {"Bathroom": 0.9, "Closet": 0.1},
    "Corridor": {"Corridor": 0.8, "Bathroom": 0.1, "Closet": 0.1},
    "Closet": {"Closet": 0.6, "Corridor": 0.2, "Bathroom": 0.2},
}
#: Name of no room: a garden, a facade, a face.
NOWHERE = ""


@dataclass(frozen=True)
class WhichRoomSettings:
    """Weights of the evidence, in e-folds of probability.

    Source: set by hand on two listings (development), reported on others.
    """

    #: Of a unit of the score of the best pose in a room, and the most that it can tell.
    place: float = 12.0
    most_place: float = 2.0
    #: Of the logarithm of the classifier's odds, and how often it knows nothing.
    kind: float = 1.4
    unknown: float = 0.2
    #: Of a name whose words are all those of a room: people give other names than their plan.
    #: Chosen on four listings with the files' names and two flats (development).
    name: float = 2.0
    #: Of photos that see the same things.
    tie: float = 4.0
    #: They are wrong together: what each tells, and how often its room is photographed, counts
    #: less, by this power of how many.
    repeated: float = 0.5
    #: Of the likeness of two photos in one room (`matches.likeness`) above what is usual. Those of
    #: a room are not independent: the sum over them counts by the root of their number.
    #: Chosen on two listings, reported on two others and two flats (development).
    alike: float = 3.0
    usually_alike: float = 0.2
    #: Share of that for photos on one storey, where floors go on from room to room. Chosen on a
    #: listing of two storeys, looked at on another.
    storey: float = 0.3
    #: Share of a tie where the rooms are open to each other.
    open_tie: float = 0.7
    #: Taken for each of at most so many photos in the same room that no ties lead to: most photos
    #: of one room have something in common.
    untied: float = 0.3
    most_untied: int = 4
    #: How often rooms are photographed, by type; others as a closet. A larger room than the usual
    #: one of its types is, by this power of how many times it is as large.
    larger: float = 0.5
    photographed: dict[str, float] = field(
        default_factory=lambda: {
            "Reception": 3.0,
            "Kitchen": 2.5,
            "Bedroom": 1.5,
            "Bathroom": 1.2,
            "Corridor": 0.5,
            "Entrance": 0.5,
            "Staircase": 0.4,
            "Unknown": 0.6,
        }
    )
    rarely: float = 0.15
    #: A main room that no other photo shows is more probable by this.
    first: float = 2.0
    main: tuple[str, ...] = ("Reception", "Kitchen", "Bedroom", "Bathroom")
    #: Probability that a photo shows no room, without evidence.
    nowhere: float = 0.03
    #: A room less probable than this is a guess: the photo more likely shows another. Rooms that
    #: no photo shows more surely are made of it where it so probably shows one of their kind.
    least: float = 0.5
    #: Of the guesses for a room those are used that are so nearly as probable as the best: others
    #: are photos of other rooms, which would mix floors. Seen on one listing; of six photos of four
    #: that .8 used and this does not, five show another room.
    near_best: float = 0.95
    #: Sweeps of the sampler that count, those before, and groups that move in each.
    sweeps: int = 1500
    warm: int = 300
    groups: int = 5


WHICH = WhichRoomSettings()


@dataclass(frozen=True)
class PhotoEvidence:
    """What one photo tells of its room."""

    #: Rooms that the photo table names; then nothing else counts.
    told: tuple[str, ...] = ()
    #: Score of the best pose in each room; empty where the photo has no frame.
    scores: Mapping[str, float] = field(default_factory=dict)
    #: How probable each of `KINDS` is, (k,) in [0, 1]; all 0 for a photo of no room; None where
    #: nothing told it.
    kinds: np.ndarray | None = None
    #: Share of the photo's name that fits each room (:func:`fitting_rooms`).
    named: Mapping[str, float] = field(default_factory=dict)

    @property
    def tells(self) -> bool:
        """Whether anything is known."""
        return bool(self.told or self.scores or self.named) or self.kinds is not None


def room_probabilities(
    house: House,
    photos: Mapping[str, PhotoEvidence],
    tied: Collection[tuple[str, str]],
    alike: Mapping[tuple[str, str], float],
) -> dict[str, dict[str, float]]:
    """Return how probable each room is for each photo; `NOWHERE` for none.

    `tied` are the pairs of photos that see the same things, `alike` tells how alike pairs look
    (:func:`plan2scene.photos.matches.likeness`). Gibbs sampling of the rooms of all
    photos, alone and together with those that they are tied to: the same input gives the same
    numbers.
    """
    names, rooms = sorted(photos), [room.id for room in house.rooms]
    if not names:
        return {}
    pairs = _pairs(names, tied)
    kindred = [_reached(k, pairs, range(len(names))) for k in range(len(names))]
    weight = np.array([1.0 + len(others) for others in pairs]) ** -WHICH.repeated
    alone = weight[:, None] * np.array([_alone(house, photos[name]) for name in names])
    known = [photos[name].tells or bool(pairs[k]) for k, name in enumerate(names)]
    near = _nearness(house)
    looks = _looks_together(names, alike)
    levels = np.array([room.level for room in house.rooms])
    one_storey = (levels[:, None] == levels).astype(float)
    frequent, first = _frequency(house)
    rng = generator(0, "which room", house.id)
    state = np.where(known, alone.argmax(axis=1), len(rooms))
    counts = np.bincount(state, minlength=len(rooms) + 1).astype(float)
    seen = np.zeros((len(names), len(rooms) + 1))

    def moved(group: Sequence[int]) -> np.ndarray:
        """Draw a room for photos of one room; return how probable each was."""
        here, held = state[group[0]], set(group)
        counts[here] -= len(group)
        log = alone[group].sum(axis=0) + np.where(counts == 0, first, 0.0)
        for more, k in enumerate(group):
            log += weight[k] * np.log(frequent + np.minimum(counts + more, 2.0) * 0.3)
        for k in group:
            kin = [state[other] for other in kindred[k] if other not in held]
            untied = counts - np.bincount(kin, minlength=len(counts))
            log[:-1] -= WHICH.untied * np.minimum(untied, WHICH.most_untied)[:-1]
            together = np.bincount(state, looks[k], len(counts))
            together[here] -= looks[k, group].sum()
            log[:-1] += (together / np.sqrt(np.maximum(counts, 1.0)))[:-1]
            if not one_storey.all():  # else it says the same of all rooms
                sums, there = one_storey @ together[:-1], one_storey @ counts[:-1]
                storey = sums / np.sqrt(np.maximum(there, 1.0))
                log[:-1] += WHICH.storey * (storey - storey.mean())
            for other in pairs[k]:
                log += WHICH.tie * (near.diagonal() / 2 if other in held else near[state[other]])
                if len(group) > 1 and other not in held:
                    log[state[other]] = -np.inf  # there the group would be another one
        odds = np.exp(log - log.max())
        state[group] = np.searchsorted(np.cumsum(odds), rng.random() * odds.sum())
        counts[state[group[0]]] += len(group)
        return np.asarray(odds / odds.sum())

    free = [k for k, name in enumerate(names) if not photos[name].told and known[k]]
    paired = [k for k in free if pairs[k]]
    for sweep in range(WHICH.warm + WHICH.sweeps):
        for k in free:
            odds = moved([k])
            if sweep >= WHICH.warm:
                seen[k] += odds
        for first_of in rng.choice(paired, WHICH.groups) if paired else ():
            together = np.flatnonzero(state == state[first_of])
            group = sorted(_reached(int(first_of), pairs, set(together.tolist())))
            if len(group) > 1 and set(group) <= set(free):
                moved(group)
    found = {}
    for k, name in enumerate(names):
        told = photos[name].told
        if told:
            found[name] = {room: 1.0 for room in told}
            continue
        if not known[k]:
            found[name] = {NOWHERE: 1.0}
            continue
        share = seen[k] / seen[k].sum()
        found[name] = {
            room: round(float(p), 4) for room, p in zip([*rooms, NOWHERE], share, strict=True)
        }
    return found


def fitting_rooms(house: House, name: str) -> dict[str, float]:
    """Return how much of a photo's name fits each room, of the words that fit any; empty for none.

    A room's words are those of its name, id and types: "master_bedroom_2" fits a room "Master",
    a bedroom, better than another bedroom.
    """
    said = _words(name) | {kind.lower() for kind in room_types(name.replace("_", " "))}
    fits = {
        room.id: {
            word
            for word in _words(f"{room.name} {room.id}") | {kind.lower() for kind in room.types}
            if any(_is_word(own, word) for own in said)
        }
        for room in house.rooms
    }
    known = set().union(*fits.values())
    return {room: len(words) / len(known) for room, words in fits.items() if words}


def _words(text: str) -> set[str]:
    """Return the words of a name in lower case, without numbers and without "room".

    Numbers tell nothing: on real listings "bedroom 2" is as often another bedroom.
    """
    parts = re.split(r"[\W\d_]+|(?<=[a-z])(?=[A-Z])", text)
    words = {part.lower() for part in parts if len(part) > 1} - {"room"}
    return {re.sub("^(primary|principal)(?=$|bed|bath)", "master", word) for word in words}


def _is_word(own: str, word: str) -> bool:
    """Return whether a word is another, or begins or ends with it if that is long."""
    return own == word or (len(word) >= 5 and (own.startswith(word) or own.endswith(word)))


class Likely(NamedTuple):
    """The room that a photo most probably shows."""

    room_id: str
    probability: float
    #: How probable it is that the photo shows a room of one of its types.
    of_kind: float


def likely_room(house: House, rooms: Mapping[str, float]) -> Likely:
    """Return the most probable room of :func:`room_probabilities`."""
    best, probability = max(rooms.items(), key=lambda item: item[1])
    types = set(house.room(best).types) if best != NOWHERE else set()
    alike = [room.id for room in house.rooms if types & set(room.types)] or [best]
    return Likely(best, probability, sum(rooms.get(room, 0.0) for room in alike))


def used_photos(likely: Mapping[str, Likely], told: Collection[str]) -> set[str]:
    """Return the photos that rooms are made of, by what :func:`likely_room` says of each.

    Guesses are used for rooms that neither a surer photo nor the photo table (`told`) shows.
    """
    best = dict.fromkeys(told, 1.0)
    for room, p, _ in likely.values():
        best[room] = max(p, best.get(room, 0.0))
    return {
        photo
        for photo, (room, p, of_kind) in likely.items()
        if room != NOWHERE
        and (
            p >= WHICH.least
            or (
                best[room] < WHICH.least
                and p >= WHICH.near_best * best[room]
                and of_kind >= WHICH.least
            )
        )
    }


def _reached(photo: int, pairs: Sequence[Sequence[int]], among: Collection[int]) -> set[int]:
    """Return a photo, those `among` others that are tied to it, those tied to them, and so on."""
    found, todo = {photo}, [photo]
    while todo:
        for other in pairs[todo.pop()]:
            if other not in found and other in among:
                found.add(other)
                todo.append(other)
    return found


def _alone(house: House, photo: PhotoEvidence) -> np.ndarray:
    """Return what a photo tells by itself, (rooms + 1,) log odds; the last is no room."""
    log = np.zeros(len(house.rooms) + 1)
    if photo.told:
        log[[room.id not in photo.told for room in house.rooms] + [True]] = -1e3
        return log
    if photo.kinds is not None and not photo.kinds.any():
        log[:-1] = -1e3
        return log
    if photo.scores:
        best = max(photo.scores.values())
        for k, room in enumerate(house.rooms):
            lead = (photo.scores.get(room.id, -np.inf) - best) * WHICH.place
            log[k] += max(lead, -WHICH.most_place)
        log[-1] -= WHICH.most_place / 2
    if photo.kinds is not None:
        for k, room in enumerate(house.rooms):
            odds = float(_looks(room) @ photo.kinds) * len(KINDS)
            odds += WHICH.unknown * (1.0 - odds)
            log[k] += WHICH.kind * float(np.log(odds))
    if photo.named:
        for k, room in enumerate(house.rooms):
            log[k] += WHICH.name * photo.named.get(room.id, 0.0)
    log[-1] += np.log(WHICH.nowhere)
    return log


def _looks(room: Room) -> np.ndarray:
    """Return the shares (k,) of `KINDS` that photos of a room look like."""
    kinds = [KIND_OF[kind] for kind in room.types if kind in KIND_OF] or list(KINDS)
    return np.array([[LOOKS[kind].get(k, 0.0) for k in KINDS] for kind in kinds]).mean(axis=0)


def _frequency(house: House) -> tuple[np.ndarray, np.ndarray]:
    """Return how often each room is photographed, and what a first photo of it adds."""
    often, first = [], []
    areas = {room.id: max(room_polygon(room).area, 0.1) for room in house.rooms}
    for room in house.rooms:
        usual = (WHICH.photographed.get(t, WHICH.rarely) for t in room.types)
        alike = [areas[r.id] for r in house.rooms if set(r.types) & set(room.types)]
        larger = areas[room.id] / float(np.exp(np.mean(np.log(alike or [areas[room.id]]))))
        often.append(max(usual, default=WHICH.photographed["Unknown"]) * larger**WHICH.larger)
        first.append(WHICH.first if set(room.types) & set(WHICH.main) else 0.0)
    return np.array([*often, 1.0]), np.array([*first, 0.0])


def _nearness(house: House) -> np.ndarray:
    """Return (rooms + 1, rooms + 1) of how much photos of two rooms may be tied."""
    index = {room.id: k for k, room in enumerate(house.rooms)}
    near = np.eye(len(index) + 1)
    near[-1, -1] = 0.5
    for one, other, _ in house.passages():
        a, b = index[one], index[other]
        near[a, b] = near[b, a] = WHICH.open_tie
    return near


def _looks_together(names: Sequence[str], alike: Mapping[tuple[str, str], float]) -> np.ndarray:
    """Return (n, n) of how much two photos' looks speak for one room; 0 where they are unknown."""
    index = {name: k for k, name in enumerate(names)}
    found = np.zeros((len(names), len(names)))
    for (a, b), value in alike.items():
        if a in index and b in index:
            pair = index[a], index[b]
            found[pair] = found[pair[::-1]] = WHICH.alike * (value - WHICH.usually_alike)
    return found


def _pairs(names: Sequence[str], tied: Collection[tuple[str, str]]) -> list[list[int]]:
    """Return for each photo the others that it is tied to."""
    index = {name: k for k, name in enumerate(names)}
    pairs: list[list[int]] = [[] for _ in names]
    for a, b in tied:
        if a in index and b in index:
            pairs[index[a]].append(index[b])
            pairs[index[b]].append(index[a])
    return pairs
