"""Several drawings on one picture: find those that are storeys of the home, and align them.

Drawings are parts of the ink with blank paper between their bounding boxes. Those without rooms and
openings (tables, site plans, legends) do not belong to the home.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from scipy import ndimage
from scipy.signal import fftconvolve

from plan2scene.errors import InputError
from plan2scene_app.tracing.lettering import TextLine
from plan2scene_app.tracing.picture import PlanPicture, dark_on_light, read_plan_picture
from plan2scene_app.tracing.settings import DOOR, ROOM, SETTINGS, STAIRS, WINDOW

#: Words (no accents, lower case) of a caption, by the storey's number; `_` is a space.
_STOREYS = {
    -1: "basement cellar keller untergeschoss ug souterrain sous_sol sotano seminterrato kallare",
    0: "ground erdgeschoss eg rez rdc planta_baja piano_terra bottenvaning begane_grond parterre",
    1: "first 1st upper obergeschoss 1_og og 1er primo primera planta_alta eerste ovre etage_1",
    2: "second 2nd 2_og 2eme secondo segunda tweede",
    3: "third 3rd 3_og",
    4: "attic loft dachgeschoss dg mansard mansarda combles zolder vind roof",
}
_CAPTION_WORDS = 5  #: a line of more words is no caption


def find_drawings(image: np.ndarray) -> tuple[np.ndarray, int]:
    """Return the drawings (h, w) int32 of a picture, numbered from 1, 0 for none, and their count.

    The picture (h, w, 3) uint8 has no text. Drawings are numbered in reading order.
    """
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY).astype(np.float32)
    ink = np.abs(grey - np.percentile(grey, 90)) > SETTINGS.drawing_ink
    side = 2 * round(SETTINGS.drawing_gap * max(ink.shape) / 2) + 1
    places, _ = ndimage.label(cv2.dilate(ink.astype(np.uint8), np.ones((side, side), np.uint8)))
    boxes = [
        [box[1].start, box[0].start, box[1].stop, box[0].stop]
        for box in ndimage.find_objects(places)
    ]
    group = np.arange(len(boxes) + 1)
    order = sorted(range(len(boxes)), key=lambda k: -_size(boxes[k]))
    kept: list[int] = []
    for k in order:
        near = [j for j in kept if _overlap(boxes[k], boxes[j])]
        if not near:
            kept.append(k)
            continue
        for j in near[1:]:  # a part that overlaps two drawings joins them
            group[group == j + 1] = near[0] + 1
            kept.remove(j)
            boxes[near[0]] = _union(boxes[near[0]], boxes[j])
        group[group == k + 1] = near[0] + 1
        boxes[near[0]] = _union(boxes[near[0]], boxes[k])
    largest = max((_size(boxes[k]) for k in kept), default=0)
    kept = [k for k in kept if _size(boxes[k]) >= SETTINGS.drawing_size * largest]
    kept = sorted(kept, key=lambda k: -_size(boxes[k]))[: SETTINGS.most_drawings]
    row = max((boxes[k][3] - boxes[k][1] for k in kept), default=1) / 2
    kept.sort(key=lambda k: (round((boxes[k][1] + boxes[k][3]) / 2 / row / 2), boxes[k][0]))
    numbers = np.zeros(len(boxes) + 1, np.int32)
    for number, k in enumerate(kept, start=1):
        numbers[group == k + 1] = number
    numbers[0] = 0
    return numbers[places], len(kept)


def _size(box: Sequence[int]) -> int:
    return (box[2] - box[0]) * (box[3] - box[1])


def _overlap(one: Sequence[int], other: Sequence[int]) -> bool:
    return all(one[k] < other[k + 2] and other[k] < one[k + 2] for k in (0, 1))


def _union(one: Sequence[int], other: Sequence[int]) -> list[int]:
    return [*np.minimum(one[:2], other[:2]).tolist(), *np.maximum(one[2:], other[2:]).tolist()]


def page_of_storeys(paths: Sequence[Path], names: Sequence[str] = ()) -> np.ndarray:
    """Return one white page (h, w, 3) uint8 sRGB with the pictures of a home's storeys.

    They stand in the given order, or in that of the storeys that all their `names` tell (default:
    the files' paths). InputError with the name as `read_plan_picture`.
    """
    names = names or [str(path) for path in paths]
    pictures = []
    for path, name in zip(paths, names, strict=True):
        try:
            pictures.append(read_plan_picture(path))
        except InputError as fault:
            raise InputError(fault.expected, fault.found, file=name) from None
    told = [storey_told(Path(name).stem.replace("_", " ")) for name in names]
    order = list(range(len(paths)))
    if None not in told and len(set(told)) == len(told):
        order.sort(key=lambda k: told[k] or 0)
    return on_one_page([pictures[k] for k in order]).image


def on_one_page(pictures: Sequence[PlanPicture]) -> PlanPicture:
    """Return one white page with pictures of storeys, side by side or one below the other.

    Those of one size have one scale, so that a pixel of the page is `shrunk` pixels of their files;
    others are made equally long.
    """
    images, texts = [], []
    one_scale = len({picture.file_size for picture in pictures}) == 1
    one_scale &= all(picture.sheet is None for picture in pictures)
    coarsest = max(picture.shrunk for picture in pictures)
    shortest = min(max(picture.image.shape[:2]) for picture in pictures)
    for picture in pictures:
        image = dark_on_light(picture.image)
        paper = np.maximum(np.percentile(image, 90, axis=(0, 1)), 1.0)
        image = np.minimum(image * (255.0 / paper), 255.0).astype(np.uint8)
        zoom = picture.shrunk / coarsest if one_scale else shortest / max(image.shape[:2])
        images.append(cv2.resize(image, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_AREA))
        texts.append([line.moved(zoom) for line in picture.texts])
    sizes = np.array([image.shape[:2] for image in images])
    gap = round(SETTINGS.page_gap * float(sizes.max()))
    axis = int(sizes[:, 1].sum() <= sizes[:, 0].sum())  # 1: side by side, 0: one below the other
    size = sizes.max(axis=0) + 2 * gap
    size[axis] = sizes[:, axis].sum() + gap * (len(images) + 1)
    page = np.full((*size, 3), 255, np.uint8)
    place = [gap, gap]
    lines = []
    for image, (height, width), own in zip(images, sizes, texts, strict=True):
        page[place[0] : place[0] + height, place[1] : place[1] + width] = image
        lines += [line.moved(1.0, (place[1], place[0])) for line in own]
        place[axis] += image.shape[axis] + gap
    return PlanPicture(page, coarsest, texts=tuple(lines))


def shows_a_home(structure: np.ndarray) -> bool:
    """Return whether a structure (h, w) uint8 has rooms, a door, and enough openings for the rooms.

    The door is needed because cells of a table look like rooms with windows.
    """
    rooms, count = ndimage.label(structure == ROOM)
    sizes = np.bincount(rooms.ravel(), minlength=count + 1)[1:]
    rooms = int((sizes > 0.02 * sizes.sum()).sum()) if count else 0
    doors, windows = (_drawn_openings(structure == label) for label in (DOOR, WINDOW))
    return doors > 0 and 0 < rooms <= SETTINGS.rooms_an_opening * (doors + windows)


def _drawn_openings(drawn: np.ndarray) -> int:
    """Return the number of components of `drawn` (h, w) bool as long as a door or window."""
    places, count = ndimage.label(drawn, np.ones((3, 3)))
    sides = [max(s.stop - s.start for s in box) for box in ndimage.find_objects(places, count)]
    return sum(side >= SETTINGS.drawing_opening_px for side in sides)


@dataclass(frozen=True)
class Storey:
    """A drawing as a level of the home."""

    drawing: int  #: number of the drawing
    name: str  #: as written, else made up
    floor: int  #: 0 for the ground floor, 1 for the next one up
    shift: tuple[float, float]  #: pixels of the frame that bring it onto the ground floor
    told: bool  #: whether a caption names the storey


def storeys_of(
    owner: np.ndarray,
    rooms: np.ndarray,
    probabilities: np.ndarray,
    lines: Sequence[TextLine],
    ppm: float,
) -> list[Storey]:
    """Return the storeys that drawings show, the lowest first.

    `owner` and `rooms` (h, w) int32 hold the numbers of drawings and rooms, 0 for none. `lines` are
    in the frame's pixels. Drawings without a caption rank between ground and first floor, in
    reading order.
    """
    drawings = [int(n) for n in np.unique(owner[rooms > 0]) if n]
    captions = _captions(owner, rooms, drawings, lines)
    ranked = sorted(drawings, key=lambda n: (captions[n][0] if n in captions else 0.5 + n / 100, n))
    ground = sum(n in captions and captions[n][0] < 0 for n in ranked)
    ground = min(ground, len(ranked) - 1)
    base = ranked[ground]
    storeys = []
    for place, number in enumerate(ranked):
        floor = place - ground
        name = captions[number][1] if number in captions else f"floor {floor}"
        shift = (0.0, 0.0)
        if number != base:
            shift = _shift(owner, rooms, probabilities, (base, number), ppm)
        storeys.append(Storey(number, name, floor, shift, number in captions))
    return storeys


def _captions(
    owner: np.ndarray, rooms: np.ndarray, drawings: Sequence[int], lines: Sequence[TextLine]
) -> dict[int, tuple[int, str]]:
    """Return {drawing: (storey number, caption)} by the nearest caption outside all rooms."""
    boxes = {n: _box((owner == n) & (rooms > 0)) for n in drawings}
    captions: dict[int, tuple[float, int, str]] = {}
    for line in lines:
        height = storey_told(line.text)
        x, y = (round(v) for v in line.middle)
        if height is None:
            continue
        if 0 <= y < rooms.shape[0] and 0 <= x < rooms.shape[1] and rooms[y, x]:
            continue
        away = {n: _distance(box, line.middle) for n, box in boxes.items()}
        nearest = min(away, key=lambda n: away[n])
        if nearest not in captions or away[nearest] < captions[nearest][0]:
            captions[nearest] = (away[nearest], height, line.text)
    return {n: (height, text) for n, (_, height, text) in captions.items()}


def storey_told(text: str) -> int | None:
    """Return the number of the storey that a caption names; None for other texts."""
    plain = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode().lower()
    words = re.findall(r"[a-z]+|\d+(?:st|nd|rd|er|eme|e)?", plain)
    if not 0 < len(words) <= _CAPTION_WORDS:
        return None
    joined = f"_{'_'.join(words)}_"
    storey_numbers = [
        h for h, names in _STOREYS.items() if any(f"_{n}_" in joined for n in names.split())
    ]
    return max(storey_numbers) if storey_numbers else None


def _box(mask: np.ndarray) -> tuple[int, int, int, int]:
    rows, columns = np.nonzero(mask)
    return int(columns.min()), int(rows.min()), int(columns.max()) + 1, int(rows.max()) + 1


def _distance(box: Sequence[float], point: Sequence[float]) -> float:
    """Return the distance from a point to a box."""
    off = [max(box[k] - point[k], 0.0, point[k] - box[k + 2]) for k in (0, 1)]
    return float(np.hypot(off[0], off[1]))


def _shift(
    owner: np.ndarray,
    rooms: np.ndarray,
    probabilities: np.ndarray,
    pair: tuple[int, int],
    ppm: float,
) -> tuple[float, float]:
    """Return the shift (x, y) that brings the second of two drawings onto the first.

    It maximises the overlap of floors, outer walls and stairs, the latter two weighted by
    `SETTINGS.walls_meet` and `SETTINGS.stairs_meet`.
    """
    step = max(1, round(ppm / 8))
    stairs = probabilities[STAIRS] > 0.5
    boxes = [_box((owner == number) & (rooms > 0)) for number in pair]
    floors, flights = [], []
    for number, (x0, y0, x1, y1) in zip(pair, boxes, strict=True):
        part = (slice(y0, y1, step), slice(x0, x1, step))
        floor_mask = (owner[part] == number) & (rooms[part] > 0)
        floors.append(floor_mask.astype(np.float32))
        flights.append((floor_mask & stairs[part]).astype(np.float32))
    walls = [floor - ndimage.binary_erosion(floor, np.ones((3, 3))) for floor in floors]
    score = _met(floors) + SETTINGS.walls_meet * _met(walls) + SETTINGS.stairs_meet * _met(flights)
    y, x = np.unravel_index(int(score.argmax()), score.shape)
    rows, columns = floors[1].shape
    dx = (x - columns + 1) * step + boxes[0][0] - boxes[1][0]
    dy = (y - rows + 1) * step + boxes[0][1] - boxes[1][1]
    return float(dx), float(dy)


def _met(planes: Sequence[np.ndarray]) -> np.ndarray:
    """Return the overlap of two planes for every shift of the second (cross-correlation)."""
    return np.asarray(fftconvolve(planes[0], planes[1][::-1, ::-1]).round(3))
