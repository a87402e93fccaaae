"""Find the room that each photo shows, from all evidence, for all photos of a home jointly.

One photo alone hardly determines its room. The evidence: how well the photo's labels agree with
each room of the plan, what the room is used for, other photos of the same things, the photo's name,
and that people photograph every main room of a home before they take many photos of one.
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

#: Kind (of `KINDS`) of each room type; a room of another type may be of any kind.
KIND_OF = {kind: kind for kind in KINDS} | {"Entrance": "Corridor", "Staircase": "Corridor"}
#: For rooms of each kind, the shares of the kinds that their photos look like: many kitchens have a
#: table, many bedrooms a desk.
LOOKS = {
    "Reception": {"Reception": 0.8, "Kitchen": 0.1, "Bedroom": 0.1},
    "Bedroom": {"Bedroom": 0.8, "Reception": 0.2},
    "Kitchen": {"Kitchen": 0.65, "Reception": 0.35},
    "Bathroom": {"Bathroom": 0.9, "Closet": 0.1},
    "Corridor": {"Corridor": 0.8, "Bathroom": 0.1, "Closet": 0.1},
    "Closet": {"Closet": 0.6, "Corridor": 0.2, "Bathroom": 0.2},
}
#: Id for "no room": the photo shows a garden, a facade, a face.
NOWHERE = ""


@dataclass(frozen=True)
class WhichRoomSettings:
    """Weights of the evidence, added to log odds (natural logarithm).

    Source: set by hand on two listings (development), reported on others.
    """

    #: Weight of the score of the best pose in a room, and the most it takes off against the best.
    #: The latter was chosen on two flats (development), reported on four listings.
    place: float = 12.0
    most_place: float = 4.0
    #: Weight of the log odds of the room classifier, and the share of photos that it cannot judge.
    kind: float = 1.4
    unknown: float = 0.2
    #: Weight of a photo's name if all its known words fit the room: people use other names than
    #: their plan. Chosen on four listings with the files' names and two flats (development).
    name: float = 2.0
    #: Weight of a tie between two photos in one room: they see the same things.
    tie: float = 4.0
    #: Tied photos make the same mistakes. The evidence of each photo alone, and how often its room
    #: is photographed, is multiplied by (1 + number of photos tied to it) to the power of -this.
    repeated: float = 0.5
    #: Weight of the likeness of two photos in one room (`matches.likeness`), after `usually_alike`
    #: is subtracted. Photos of a room are not independent: their sum is divided by the square root
    #: of their number. Chosen on two listings, reported on two others and two flats (development).
    alike: float = 3.0
    usually_alike: float = 0.2
    #: Factor of the same evidence for photos on one storey, where a floor often continues from room
    #: to room. Chosen on a listing of two storeys, looked at on another.
    storey: float = 0.3
    #: Factor of `tie` if the photos are in two rooms that are open to each other.
    open_tie: float = 0.7
    #: Subtracted for each photo in the same room that no chain of ties connects to this one, for at
    #: most `most_untied` photos: most photos of one room have something in common.
    untied: float = 0.3
    most_untied: int = 4
    #: `photographed`: how often rooms are photographed, by type; `rarely` for other types. It is
    #: multiplied by (area / geometric mean area of the home's rooms of its types) ** `larger`.
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
    #: Added to the log odds of a room of a `main` type that no other photo shows.
    first: float = 2.0
    main: tuple[str, ...] = ("Reception", "Kitchen", "Bedroom", "Bathroom")
    #: Prior weight of no room, against 1 for each room.
    nowhere: float = 0.03
    #: A photo's most probable room is a guess if it is less probable than this. A guess is used for
    #: a room that no photo shows with at least this probability, and only if the photo shows a room
    #: of the same kind with at least this probability.
    least: float = 0.5
    #: Of the guesses for a room, those with at least this share of the best one's probability are
    #: used: others show other rooms, which would mix floors. Seen on one listing; of six photos of
    #: four listings that .8 used and this does not, five show another room.
    near_best: float = 0.95
    #: Sweeps of the sampler that count, sweeps before them, and groups moved in each sweep.
    sweeps: int = 1500
    warm: int = 300
    groups: int = 5


WHICH = WhichRoomSettings()


@dataclass(frozen=True)
class PhotoEvidence:
    """Evidence of the room of one photo."""

    #: Rooms that the photo table names for it; if any, other evidence is ignored.
    told: tuple[str, ...] = ()
    #: Score of the best pose in each room; empty where the photo has no frame.
    scores: Mapping[str, float] = field(default_factory=dict)
    #: Probability of each of `KINDS`, (k,) in [0, 1]; all 0 for a photo of no room; None if
    #: unknown.
    kinds: np.ndarray | None = None
    #: Share of the photo's name that fits each room (:func:`fitting_rooms`).
    named: Mapping[str, float] = field(default_factory=dict)

    @property
    def tells(self) -> bool:
        """Whether there is any evidence."""
        return bool(self.told or self.scores or self.named) or self.kinds is not None


def room_probabilities(
    house: House,
    photos: Mapping[str, PhotoEvidence],
    tied: Collection[tuple[str, str]],
    alike: Mapping[tuple[str, str], float],
) -> dict[str, dict[str, float]]:
    """Return the probability of each room for each photo; the key `NOWHERE` is no room.

    `tied` are the pairs of photos that see the same things, `alike` is the likeness of pairs
    (:func:`plan2scene.photos.matches.likeness`). The method is Gibbs sampling of the rooms of all
    photos; it moves single photos and groups of tied ones. The same input gives the same numbers.
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
    room_counts = np.zeros((len(names), len(rooms) + 1))

    def moved(group: Sequence[int]) -> np.ndarray:
        """Draw a new room for a group of photos in one room; return each room's probability."""
        current_room, group_photos = state[group[0]], set(group)
        counts[current_room] -= len(group)
        log = alone[group].sum(axis=0) + np.where(counts == 0, first, 0.0)
        for more, k in enumerate(group):
            log += weight[k] * np.log(frequent + np.minimum(counts + more, 2.0) * 0.3)
        for k in group:
            kin = [state[other] for other in kindred[k] if other not in group_photos]
            untied = counts - np.bincount(kin, minlength=len(counts))
            log[:-1] -= WHICH.untied * np.minimum(untied, WHICH.most_untied)[:-1]
            together = np.bincount(state, looks[k], len(counts))
            together[current_room] -= looks[k, group].sum()
            log[:-1] += (together / np.sqrt(np.maximum(counts, 1.0)))[:-1]
            if not one_storey.all():  # on a single storey it is the same for all rooms
                sums, storey_counts = one_storey @ together[:-1], one_storey @ counts[:-1]
                storey = sums / np.sqrt(np.maximum(storey_counts, 1.0))
                log[:-1] += WHICH.storey * (storey - storey.mean())
            for other in pairs[k]:
                log += WHICH.tie * (
                    near.diagonal() / 2 if other in group_photos else near[state[other]]
                )
                if len(group) > 1 and other not in group_photos:
                    log[state[other]] = -np.inf  # there the tied photo would join the group
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
                room_counts[k] += odds
        for first_of in rng.choice(paired, WHICH.groups) if paired else ():
            together = np.flatnonzero(state == state[first_of])
            group = sorted(_reached(int(first_of), pairs, set(together.tolist())))
            if len(group) > 1 and set(group) <= set(free):
                moved(group)
    probabilities = {}
    for k, name in enumerate(names):
        listed_rooms = photos[name].told
        if listed_rooms:
            probabilities[name] = {room: 1.0 for room in listed_rooms}
            continue
        if not known[k]:
            probabilities[name] = {NOWHERE: 1.0}
            continue
        share = room_counts[k] / room_counts[k].sum()
        probabilities[name] = {
            room: round(float(p), 4) for room, p in zip([*rooms, NOWHERE], share, strict=True)
        }
    return probabilities


def fitting_rooms(house: House, name: str) -> dict[str, float]:
    """Return, for each room that fits a photo's name, its share of all rooms' matched words.

    A room's words are those of its name, id and types: "master_bedroom_2" fits a bedroom called
    "Master" better than another bedroom. Rooms without a matched word are left out.
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
    matched_words = set().union(*fits.values())
    return {room: len(words) / len(matched_words) for room, words in fits.items() if words}


def _words(text: str) -> set[str]:
    """Return the words of a name in lower case, without numbers and without "room".

    Numbers tell nothing: on real listings "bedroom 2" is as often another bedroom.
    """
    parts = re.split(r"[\W\d_]+|(?<=[a-z])(?=[A-Z])", text)
    words = {part.lower() for part in parts if len(part) > 1} - {"room"}
    return {re.sub("^(primary|principal)(?=$|bed|bath)", "master", word) for word in words}


def _is_word(own: str, word: str) -> bool:
    """Return whether `own` equals `word`, or begins or ends with it if `word` is long."""
    return own == word or (len(word) >= 5 and (own.startswith(word) or own.endswith(word)))


class Likely(NamedTuple):
    """The room that a photo most probably shows."""

    room_id: str
    probability: float
    #: Probability that the photo shows this room or another of one of its types.
    of_kind: float


def likely_room(house: House, rooms: Mapping[str, float]) -> Likely:
    """Return the most probable room; `rooms` is one photo's entry of :func:`room_probabilities`."""
    best, probability = max(rooms.items(), key=lambda item: item[1])
    types = set(house.room(best).types) if best != NOWHERE else set()
    alike = [room.id for room in house.rooms if types & set(room.types)] or [best]
    return Likely(best, probability, sum(rooms.get(room, 0.0) for room in alike))


def used_photos(likely: Mapping[str, Likely], told: Collection[str]) -> set[str]:
    """Return the photos whose most probable room (:func:`likely_room`) is used as their room.

    A guess is used only if neither the photo table (`told`) nor a surer photo shows its room.
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
    """Return the photos `among` others that a chain of ties connects to a photo, and itself."""
    found, todo = {photo}, [photo]
    while todo:
        for other in pairs[todo.pop()]:
            if other not in found and other in among:
                found.add(other)
                todo.append(other)
    return found


def _alone(house: House, photo: PhotoEvidence) -> np.ndarray:
    """Return the log odds (rooms + 1,) of the rooms from one photo alone; the last is no room."""
    log = np.zeros(len(house.rooms) + 1)
    if photo.told:
        log[[room.id not in photo.told for room in house.rooms] + [True]] = -1e3
        return log
    if photo.kinds is not None and not photo.kinds.any():
        log[:-1] = -1e3
        return log
    if photo.scores:
        scores = np.array([photo.scores.get(room.id, -np.inf) for room in house.rooms])
        leads = (scores - max(photo.scores.values())) * WHICH.place
        log[:-1] += np.maximum(leads, -WHICH.most_place)
        log[-1] -= WHICH.most_place / 2
    if photo.kinds is not None:
        for k, room in enumerate(house.rooms):
            odds = float(_looks(room) @ photo.kinds) * len(KINDS)
            odds += WHICH.unknown * (1.0 - odds)
            log[k] += WHICH.kind * float(np.log(odds))
    log[:-1] += [WHICH.name * photo.named.get(room.id, 0.0) for room in house.rooms]
    log[-1] += np.log(WHICH.nowhere)
    return log


def _looks(room: Room) -> np.ndarray:
    """Return the share (k,) of a room's photos that look like each of `KINDS`."""
    kinds = [KIND_OF[kind] for kind in room.types if kind in KIND_OF] or list(KINDS)
    return np.array([[LOOKS[kind].get(k, 0.0) for k in KINDS] for kind in kinds]).mean(axis=0)


def _frequency(house: House) -> tuple[np.ndarray, np.ndarray]:
    """Return how often each room is photographed, and the bonus of its first photo (log odds)."""
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
    """Return the factor of a tie (rooms + 1, rooms + 1) between photos in two rooms, 0 to 1."""
    index = {room.id: k for k, room in enumerate(house.rooms)}
    near = np.eye(len(index) + 1)
    near[-1, -1] = 0.5
    for one, other, _ in house.passages():
        a, b = index[one], index[other]
        near[a, b] = near[b, a] = WHICH.open_tie
    return near


def _looks_together(names: Sequence[str], alike: Mapping[tuple[str, str], float]) -> np.ndarray:
    """Return the log odds (n, n) that two photos show one room, from their looks; 0 if unknown."""
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
