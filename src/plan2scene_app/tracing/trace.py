"""From a picture of a plan to a plan in metres, a list of doubts and an overlay to check it by.

Each step is a module of this package: labels, regions, polygons, openings, texts, scale.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from scipy import ndimage
from shapely.geometry import Polygon

from plan2scene.errors import InputError
from plan2scene.house import DEFAULT_HEIGHT, OPEN_AIR
from plan2scene.images import write_png
from plan2scene.io import write_json, write_text
from plan2scene.plans.plan_json import FORMAT, house_of_plan
from plan2scene.plans.room_names import is_garage, room_types
from plan2scene.plans.validate import validate_house
from plan2scene.plugins import pip_command
from plan2scene.weights import MODELS
from plan2scene_app.pdf import page_count
from plan2scene_app.plan_formats.axes import HEIGHTS
from plan2scene_app.plan_formats.measures import sides_in_feet
from plan2scene_app.tracing.double_walls import with_filled_walls
from plan2scene_app.tracing.drawings import Storey, shows_a_home, storeys_of
from plan2scene_app.tracing.drawn_stairs import TracedFlight, covered, find_treads, flights_of
from plan2scene_app.tracing.fixtures import TracedFixture, find_fixtures, with_types_by_fixtures
from plan2scene_app.tracing.ink import (
    drawn_solid,
    with_drawn_doors,
    with_drawn_walls,
    with_sliding_doors,
    with_swings,
    with_swung_windows,
    with_whole_windows,
    without_standing_lines,
)
from plan2scene_app.tracing.legend import with_legend
from plan2scene_app.tracing.lettering import TextLine, lines_of, reader_installed, without_text
from plan2scene_app.tracing.looks import Look, drawn_homes, first_looks, look_at, of_drawing, only
from plan2scene_app.tracing.named_areas import with_named_areas, without_counters
from plan2scene_app.tracing.open_rooms import with_open_rooms
from plan2scene_app.tracing.openings import TracedOpening, find_openings, within_walls
from plan2scene_app.tracing.pages import read_plan_pages
from plan2scene_app.tracing.picture import (
    Frame,
    dark_on_light,
    door_widths,
    drawn_size,
    first_scale,
    how_sure,
    main_direction,
    outline_of,
    refuse_other_pictures,
    scale_by_doors,
    straightened,
    whole,
)
from plan2scene_app.tracing.regions import (
    Regions,
    find_regions,
    floor_count,
    structure_of,
    with_passages,
    without_pockets,
)
from plan2scene_app.tracing.rooms import (
    TracedRoom,
    describe_rooms,
    room_polygons,
    with_garage_doors,
    with_terrace_doors,
    with_types_by_marks,
    without_inner_windows,
    without_rails,
)
from plan2scene_app.tracing.scale import (
    RoomSize,
    Scale,
    chain_evidence,
    find_scale,
    room_evidence,
    told_area,
)
from plan2scene_app.tracing.segmenter import PlanSegmenter, load_plan_segmenter
from plan2scene_app.tracing.settings import (
    FIXTURE_LABELS,
    FIXTURE_MODEL,
    MODEL,
    OUTSIDE,
    PLAN_LABELS,
    ROOM,
    SETTINGS,
)
from plan2scene_app.tracing.sheet import Sheet
from plan2scene_app.tracing.thin_walls import with_thin_walls

#: Least width of an opening of each kind, metres.
LEAST_WIDTH = {
    "door": SETTINGS.least_door,
    "window": SETTINGS.least_window,
    "passage": SETTINGS.least_passage,
}


@dataclass(frozen=True)
class TracedPlan:
    """What was read from a picture. Lengths are pixels of the frame, `metres` each."""

    picture: np.ndarray  #: (h, w, 3) uint8 as worked on
    frame: Frame
    rooms: tuple[TracedRoom, ...]
    openings: tuple[TracedOpening, ...]
    scale: Scale  #: of the frame's pixels
    wall_px: float
    #: Pixels of the file (of its straightened sheet, if it shows one) for one of the picture.
    shrunk: float
    corner: tuple[float, float]  #: upper left corner of the picture there, pixels (x, y)
    sure: float  #: mean probability of what was found
    read: bool  #: whether text was read
    storeys: tuple[Storey, ...] = ()  #: the lowest first; none for a plan of one drawing
    flights: tuple[TracedFlight, ...] = ()
    fixtures: tuple[TracedFixture, ...] = ()
    left_out: int = 0  #: number of drawings that show no home
    sheet: Sheet | None = None  #: the sheet of paper that the file shows
    pages: tuple[int, ...] = (1,)  #: numbers of the pages that are read
    page_count: int = 1  #: number of the file's pages

    @property
    def metres(self) -> float:
        """Size of a pixel of the frame in metres."""
        return self.scale.metres_per_pixel

    @property
    def file_metres(self) -> float:
        """Size of a pixel of the file in metres."""
        return self.metres * self.frame.zoom / self.shrunk

    def in_file(self, points: np.ndarray) -> np.ndarray:
        """Return points (n, 2) of the frame in pixels of the file, or of its straightened sheet."""
        return self.frame.to_picture(points) * self.shrunk + self.corner


def trace_picture(
    path: str | Path,
    *,
    metres_per_pixel: float | None = None,
    model: str | Path | None = None,
    fixture_model: str | Path | None = None,
) -> TracedPlan:
    """Return the plan that a picture shows.

    If `metres_per_pixel` is given, for pixels of the file, it is used instead of written sizes.
    `model` and `fixture_model` are weights to use instead of the embedded ones.
    Raises InputError if the picture shows no plan.
    """
    segmenter = load_plan_segmenter(model or MODELS / f"{MODEL}.safetensors")
    picture, pages = read_plan_pages(path, segmenter)
    page = dark_on_light(picture.image)
    texts = lines_of(page, picture.texts)
    read = bool(picture.texts) or reader_installed()
    page_alone = without_text(page, texts)
    texts = with_legend(texts)
    seen = _seen(page_alone, segmenter, texts)
    frame, probabilities, regions = seen.frame, seen.probabilities, seen.regions
    polygons = _polygons(seen)
    openings = _openings(seen, polygons)
    sure = how_sure(probabilities, regions)
    refuse_other_pictures(path, picture.image, sure, polygons, len(openings))
    lines = _in_frame(texts, frame)
    rooms = describe_rooms(regions, polygons, probabilities, lines)
    given = metres_per_pixel and metres_per_pixel * picture.shrunk / frame.zoom
    scale = _scale(regions, rooms, openings, lines, given)
    regions = with_open_rooms(regions, polygons, frame.image, lines, scale.metres_per_pixel)
    if regions is not seen.regions:
        seen = replace(seen, regions=regions)
        polygons = _polygons(seen)
        openings = _openings(seen, polygons)
        rooms = describe_rooms(regions, polygons, probabilities, lines)
        scale = _scale(regions, rooms, openings, lines, given)
    treads = find_treads(frame.image, regions.ppm)
    stepped = {room.number: covered(treads, regions.floors == room.number) for room in rooms}
    metres = scale.metres_per_pixel
    rooms = with_types_by_marks(rooms, openings, regions, frame.image, stepped, metres)
    drawings = _drawings_of_rooms(seen)
    rooms = [replace(room, drawing=drawings[room.number]) for room in rooms]
    storeys = []
    if len({room.drawing for room in rooms}) > 1:
        storeys = storeys_of(seen.owner, regions.rooms, probabilities, lines, regions.ppm)
    raised = {storey.drawing for storey in storeys if storey.floor > 0}
    upstairs = [room.number for room in rooms if room.drawing in raised]
    image_and_wall = frame.image, regions.wall_px
    garages = [room.number for room in rooms if is_garage(room.name)]
    openings = with_swung_windows(openings, *image_and_wall, upstairs)
    openings = with_whole_windows(openings, polygons, *image_and_wall, regions.ppm, garages)
    open_air = {room.number for room in rooms if OPEN_AIR.intersection(room.types)}
    if drawn_solid(regions.structure, frame.image, regions.ppm):
        openings = with_sliding_doors(openings, polygons, *image_and_wall, regions.ppm, open_air)
    openings = without_inner_windows(openings, rooms, SETTINGS.widest_door / metres)
    openings = with_garage_doors(openings, garages, SETTINGS.garage_door / metres)
    openings = without_rails(openings, polygons, open_air)
    openings = with_terrace_doors(openings, open_air, SETTINGS.terrace_door / metres)
    openings = within_walls(openings, polygons, SETTINGS.overhang / metres)
    kept = tuple(o for o in openings if o.width * metres >= LEAST_WIDTH[o.kind])
    fixture_weights = fixture_model or MODELS / f"{FIXTURE_MODEL}.safetensors"
    fixture_segmenter = load_plan_segmenter(fixture_weights, FIXTURE_LABELS)
    fixtures = find_fixtures(page, frame, rooms, kept, metres, fixture_segmenter)
    rooms, fixtures = with_types_by_fixtures(rooms, fixtures, metres)
    return TracedPlan(
        picture.image,
        frame,
        tuple(rooms),
        kept,
        scale,
        regions.wall_px,
        picture.shrunk,
        picture.corner,
        sure,
        read,
        tuple(storeys),
        tuple(flights_of(treads, rooms, storeys, metres)),
        tuple(fixtures),
        seen.left_out,
        picture.sheet,
        pages,
        page_count(path),
    )


def _polygons(seen: _Seen) -> dict[int, Polygon]:
    """Return the polygons of the rooms, drawing by drawing."""
    drawings = _drawings_of_rooms(seen)
    polygons: dict[int, Polygon] = {}
    for drawing in sorted(set(drawings.values())):
        polygons |= room_polygons(seen.regions, [n for n, d in drawings.items() if d == drawing])
    return polygons


def _openings(seen: _Seen, polygons: dict[int, Polygon]) -> list[TracedOpening]:
    """Return the openings between the rooms, and how sure they are."""
    openings = find_openings(seen.regions, polygons, seen.probabilities)
    return with_swings(openings, seen.frame.image, seen.regions.wall_px)


def _drawings_of_rooms(seen: _Seen) -> dict[int, int]:
    """Return the number of the drawing that each room lies in, by the room's number."""
    rooms = seen.regions.rooms
    most = int(seen.owner.max()) + 1
    votes = np.bincount((rooms * most + seen.owner).ravel(), minlength=(rooms.max() + 1) * most)
    drawings = votes.reshape(-1, most).argmax(1)
    return {number: int(drawings[number]) for number in range(1, seen.regions.count + 1)}


@dataclass(frozen=True)
class _Seen:
    """What the network sees in the straightened picture."""

    frame: Frame
    probabilities: np.ndarray
    regions: Regions
    owner: np.ndarray  #: (h, w) int32: number of the nearest drawing, from 1
    left_out: int = 0  #: number of drawings that show no home


def _seen(image: np.ndarray, segmenter: PlanSegmenter, texts: Sequence[TextLine]) -> _Seen:
    """Straighten a picture and find its labels and regions, one drawing at a time."""
    looks, numbers, count = first_looks(image, segmenter)
    filled = with_filled_walls(image, looks)
    if filled is not image:
        image = filled
        looks, numbers, count = first_looks(image, segmenter)
    all_numbers = numbers
    homes = drawn_homes(looks, image) or [x for x in looks if shows_a_home(x.structure)]
    left_out = count - len(homes) if homes else 0
    home_numbers = [look.number for look in homes]
    if len(homes) < 2:
        if left_out:
            image = of_drawing(image, numbers, homes[0].number)
        if count != 1:
            looks = [look_at(whole(image, segmenter.long_side), 1, segmenter)]
        homes = looks
        numbers = np.ones_like(numbers)
    else:
        image = only(image, np.isin(numbers, [0, *(look.number for look in homes)]))
    first = homes[0]
    floor = without_pockets(first.structure, first_scale(first.structure)) == ROOM
    if len(homes) == 1 and not floor.any():
        return _as_first_seen(first)
    zooms = [look.frame.zoom for look in homes]
    widths = [
        w / z for look, z in zip(homes, zooms, strict=True) for w in door_widths(look.structure)
    ]
    sizes = [drawn_size(look.structure) / z for look, z in zip(homes, zooms, strict=True)]
    rough_ppm = scale_by_doors(widths, float(np.exp(np.mean(np.log(sizes)))))
    largest = homes[int(np.argmax(sizes))]
    angle = main_direction(1 - largest.rough[ROOM:].sum(0))
    if len(homes) > 1:
        outlines = [np.argwhere(numbers == look.number)[:, ::-1].astype(float) for look in homes]
    else:
        outlines = [outline_of(first.frame, first.structure)]
    kept = (
        all_numbers if count == 1 else np.where(np.isin(all_numbers, home_numbers), all_numbers, 0)
    )
    beyond = _named_beyond(np.concatenate(outlines), kept, texts)
    frame, places = straightened(image, outlines, rough_ppm, angle, beyond=beyond)
    owner = _owners(numbers, [look.number for look in homes], frame)
    probabilities = np.zeros((len(PLAN_LABELS), *owner.shape), np.float32)
    probabilities[OUTSIDE] = 1
    for look, place in zip(homes, places, strict=True):
        own_pixels = owner[place] == look.number
        part = only(frame.image[place], own_pixels)
        part_probabilities = segmenter.probabilities(part, views=SETTINGS.views)
        probabilities[:, *place][:, own_pixels] = part_probabilities[:, own_pixels]
    structure = structure_of(probabilities)
    ppm = first_scale(structure)
    lines = _in_frame(texts, frame)
    names = [line.middle for line in lines if room_types(line.text)]
    feet = sides_in_feet(line.text for line in lines)
    room_areas = [
        (*line.middle, area) for line in lines for area in told_area(line.text, feet=feet)
    ]
    seen_walls = drawn_solid(structure, frame.image, ppm)
    if seen_walls:
        structure = with_drawn_walls(structure, frame.image, ppm)
        structure = without_standing_lines(structure, frame.image, ppm)
    divided = structure
    if not seen_walls or floor_count(structure, ppm) < SETTINGS.floors_a_name * len(names):
        divided, ppm = with_thin_walls(structure, frame.image, names, room_areas, ppm)
    thin = divided is not structure
    open_air = [line.middle for line in lines if OPEN_AIR.intersection(room_types(line.text))]
    divided = with_named_areas(divided, frame.image, names, open_air, ppm)
    divided = without_pockets(divided, ppm)
    if seen_walls:
        kitchens = [line.middle for line in lines if "Kitchen" in room_types(line.text)]
        divided = without_counters(divided, frame.image, names, kitchens, ppm)
    if not thin:
        divided = with_passages(with_drawn_doors(divided, frame.image, ppm), ppm)
    lost = (divided == ROOM).sum() / frame.zoom**2 < floor.sum() / first.frame.zoom**2 / 2
    if len(homes) == 1 and lost:
        return _as_first_seen(first, left_out)
    return _Seen(frame, probabilities, find_regions(divided, ppm), owner, left_out)


def _as_first_seen(first: Look, left_out: int = 0) -> _Seen:
    """Return what the first look saw: close up, the network may miss large empty rooms."""
    regions = find_regions(first.structure, first_scale(first.structure))
    owner = np.ones(first.structure.shape, np.int32)
    return _Seen(first.frame, first.rough, regions, owner, left_out)


def _named_beyond(outline: np.ndarray, drawn: np.ndarray, texts: Sequence[TextLine]) -> np.ndarray:
    """Return the corners (n, 2) of each drawing that has a room's name outside an outline's box.

    `outline` is (n, 2), `drawn` (h, w) int32 numbers the drawings.
    """
    low, high = outline.min(0), outline.max(0)
    name_places = [np.array(line.middle) for line in texts if room_types(line.text)]
    beyond = [place for place in name_places if (place < low).any() or (place > high).any()]
    corners = []
    for extent in ndimage.find_objects(drawn):
        if extent is None:
            continue
        rows, columns = extent
        box = np.array([[columns.start, rows.start], [columns.stop, rows.stop]], float)
        if any((box[0] < place).all() and (place < box[1]).all() for place in beyond):
            corners.append(box)
    return np.concatenate(corners) if corners else np.zeros((0, 2))


def _owners(numbers: np.ndarray, kept: Sequence[int], frame: Frame) -> np.ndarray:
    """Return the number (h, w) int32 of the kept drawing that is nearest to each pixel of a frame.

    `numbers` are the drawings in the picture.
    """
    height, width = frame.image.shape[:2]
    kept_numbers = np.where(np.isin(numbers, kept), numbers, 0).astype(np.uint8)
    frame_numbers = cv2.warpAffine(
        kept_numbers, frame.matrix, (width, height), flags=cv2.INTER_NEAREST
    )
    if not frame_numbers.any():
        return np.full(frame_numbers.shape, kept[0], np.int32)
    nearest = ndimage.distance_transform_edt(
        frame_numbers == 0, return_distances=False, return_indices=True
    )
    return np.asarray(frame_numbers[tuple(nearest)], np.int32)


def _in_frame(lines: Sequence[TextLine], frame: Frame) -> list[TextLine]:
    """Return the picture's texts with places and sizes in the frame's pixels."""
    places = frame.of_picture(np.array([line.middle for line in lines]).reshape(-1, 2))
    return [
        TextLine(
            line.text,
            (float(x), float(y)),
            (line.size[0] * frame.zoom, line.size[1] * frame.zoom),
            line.score,
        )
        for line, (x, y) in zip(lines, places, strict=True)
    ]


def _scale(
    regions: Regions,
    rooms: Sequence[TracedRoom],
    openings: Sequence[TracedOpening],
    lines: Sequence[TextLine],
    given: float | None,
) -> Scale:
    """Return the given scale, else the one on which texts, doors and rooms agree."""
    if given:
        return Scale(given, 1.0, "as given")
    areas = np.bincount(regions.floors.ravel(), minlength=regions.count + 1).astype(float)
    evidence = []
    feet = sides_in_feet(line.text for line in lines)
    # Rails and hedges give less exact sizes of rooms than walls.
    indoors = [room for room in rooms if not OPEN_AIR.intersection(room.types)]
    for room in indoors or rooms:
        rows, columns = np.nonzero(regions.floors == room.number)
        sides = float(np.ptp(columns) + 1), float(np.ptp(rows) + 1)
        evidence += room_evidence(RoomSize(float(areas[room.number]), sides, room.texts), feet=feet)
    xs, ys = _walls([room.polygon for room in rooms])
    for line in lines:
        measure = chain_evidence(line, xs, ys)
        if measure is not None:
            evidence.append(measure)
    doors = [o.width for o in openings if o.kind == "door" and o.confidence > 0.5]
    return find_scale(evidence, doors, [float(areas[room.number]) for room in rooms])


def _walls(polygons: Sequence[Polygon]) -> tuple[list[float], list[float]]:
    """Return the x and the y of all corners of polygons, sorted: the places of their walls."""
    corners = np.concatenate([np.array(p.exterior.coords) for p in polygons])
    xs, ys = (sorted(set(np.round(corners[:, axis], 1).tolist())) for axis in (0, 1))
    return xs, ys


#: Usual widths of openings in homes, metres.
_USUAL = {"door": (0.5, 2.6), "window": (0.3, 6.0), "passage": (0.5, 6.0)}
_COLOURS = {
    "door": (0, 150, 60),
    "window": (20, 90, 235),
    "passage": (240, 140, 0),
    "fixture": (0, 140, 150),
}
_FILLS = ((230, 90, 80), (90, 160, 230), (110, 190, 110), (230, 180, 70), (170, 120, 210))


#: Metres from floor to floor where a picture shows several storeys: a room's height and a slab.
STOREY = DEFAULT_HEIGHT + 0.3


def _shift(plan: TracedPlan, drawing: int) -> np.ndarray:
    """Return the shift (x, y), pixels of the frame, of a drawing onto the ground floor."""
    return np.array(next((s.shift for s in plan.storeys if s.drawing == drawing), (0.0, 0.0)))


def plan_origin(plan: TracedPlan) -> np.ndarray:
    """Return the upper left corner (x, y) of all rooms, storeys on one another, in frame pixels."""
    corners = [
        np.array(room.polygon.exterior.coords) + (_shift(plan, room.drawing) if plan.storeys else 0)
        for room in plan.rooms
    ]
    return np.asarray(np.concatenate(corners).min(0))


def place_in_picture(plan: TracedPlan, file: str) -> dict[str, Any]:
    """Return where the plan's metres lie in the file's pixels (`picture` in the schema).

    If the file shows a sheet, these are pixels of the straightened sheet. If several pages are
    read, these are pixels of one page with all of them.
    """

    def pixel(point: np.ndarray) -> np.ndarray:
        return plan.in_file(point[None])[0]

    def rounded(point: np.ndarray) -> list[float]:
        return [round(float(v), 2) for v in point]

    corner = plan_origin(plan)
    step = pixel(corner + [1, 0]) - pixel(corner)
    levels = {
        _level_id(k): rounded(pixel(corner - storey.shift)) for k, storey in enumerate(plan.storeys)
    }
    return {
        "file": file,
        "origin": rounded(pixel(corner)),
        "metres_per_pixel": round(plan.file_metres, 7),
        "turned": round(float(np.degrees(np.arctan2(step[1], step[0]))), 3),
        **({"levels": levels} if levels else {}),
        **({"pages": list(plan.pages)} if plan.page_count > 1 else {}),
        **({"sheet": _corners_of(plan.sheet)} if plan.sheet else {}),
    }


def _corners_of(sheet: Sheet) -> dict[str, Any]:
    return {"corners": sheet.corners.round(2).tolist(), "size": list(sheet.size)}


def _level_id(place: int) -> str:
    """Return the id of a level; `place` counts from 0, the lowest."""
    return f"level_{place}"


def plan_document(plan: TracedPlan, file: str = "") -> dict[str, Any]:
    """Return the plan as this program's plan JSON, in metres from its upper left corner.

    If the name of the picture's `file` is given, the JSON also holds the plan's place in it.
    Several drawings become levels.
    """
    origin = plan_origin(plan)
    level_of = {storey.drawing: _level_id(k) for k, storey in enumerate(plan.storeys)}
    drawing_of = {room.number: room.drawing for room in plan.rooms if level_of}

    def metric(point: Any, room: int) -> list[float]:
        moved = np.asarray(point) - origin + (_shift(plan, drawing_of[room]) if level_of else 0)
        return [round(float(v), 3) for v in moved * plan.metres]

    def on_level(room: int) -> dict[str, str]:
        return {"level": level_of[drawing_of[room]]} if level_of else {}

    rooms = []
    for room in plan.rooms:
        n, shape = room.number, room.polygon
        named = {"name": room.name} if room.named and room.name else {}
        entry: dict[str, Any] = {"id": room.id, **named, "types": list(room.types)}
        entry["polygon"] = [metric(p, n) for p in shape.exterior.coords[:-1]]
        holes = [[metric(p, n) for p in ring.coords[:-1]] for ring in shape.interiors]
        rooms.append(entry | ({"holes": holes} if holes else {}) | on_level(n))
    openings = []
    for number, opening in enumerate(plan.openings):
        bottom, top = HEIGHTS[opening.kind]
        openings.append(
            {
                "id": f"{opening.kind}_{number}",
                "kind": opening.kind,
                "from": metric(opening.start, opening.room),
                "to": metric(opening.end, opening.room),
                "bottom": bottom,
                "top": DEFAULT_HEIGHT if opening.full else top,
                **on_level(opening.room),
            }
        )
    stairs = []
    for number, flight in enumerate(plan.flights):
        start, end = (
            [round(float(v), 3) for v in (np.array(point) - origin) * plan.metres]
            for point in (flight.start, flight.end)
        )
        width = round(flight.width * plan.metres, 3)
        entry = {"id": f"stairs_{number}", "from": start, "to": end, "width": width}
        stairs.append(entry | {"level": _level_id(flight.storey)})
    fixtures = []
    for number, item in enumerate(plan.fixtures):
        entry = {"id": f"fixture_{number}", "type": item.kind}
        entry |= {"from": metric(item.low, item.room), "to": metric(item.high, item.room)}
        fixtures.append(entry | on_level(item.room))
    depth = round(float(np.clip(plan.wall_px * plan.metres, 0.05, 0.5)), 3)
    levels = [
        {"id": _level_id(k), "name": s.name, "elevation": round(STOREY * s.floor, 2)}
        for k, s in enumerate(plan.storeys)
    ]
    return {
        "format": FORMAT,
        "version": 1,
        **({"picture": place_in_picture(plan, file)} if file else {}),
        "wall_depth": depth,
        **({"levels": levels} if levels else {}),
        "rooms": rooms,
        "openings": openings,
        **({"stairs": stairs} if stairs else {}),
        **({"fixtures": fixtures} if fixtures else {}),
    }


def without_loose_openings(document: dict[str, Any], file: str) -> tuple[dict[str, Any], list[str]]:
    """Return a plan without the openings that are near no wall, and a message for each of them."""
    try:
        house_of_plan(document, "traced", file=file)
        return document, []
    except InputError:
        kept, loose = [], []
    for entry in document["openings"]:
        try:
            house_of_plan({**document, "openings": [entry]}, "traced", file=file)
            kept.append(entry)
        except InputError:
            x, y = np.mean([entry["from"], entry["to"]], axis=0)
            loose.append(f"a {entry['kind']} at {x:.1f}, {y:.1f} m is left out: no wall is near")
    return {**document, "openings": kept}, loose


def doubts(plan: TracedPlan) -> Iterator[str]:
    """Yield a message for everything in a plan that is a guess or unlikely."""
    scale = plan.scale
    if scale.confidence < SETTINGS.sure:
        centimetres = 100 * plan.file_metres
        yield (
            f"the scale is {scale.source} ({centimetres:.3g} cm a pixel, {scale.confidence:.0%} "
            "sure): give --metres-per-pixel"
        )
    if plan.page_count > 1:
        numbers = ", ".join(map(str, plan.pages))
        read = f"page {numbers} is" if len(plan.pages) == 1 else f"pages {numbers} are"
        yield f"of {plan.page_count} pages, {read} read; give other pages as pictures"
    if plan.sheet is not None:
        yield "a photo or screenshot of a page: only the page is read, straightened"
    if plan.sure < SETTINGS.least_sure[0]:
        yield f"only {plan.sure:.0%} sure of what the picture shows"
    if not plan.read:
        yield f"no text is read: {pip_command('plan2scene[trace]')}"
    if plan.storeys:
        names = ", ".join(storey.name for storey in plan.storeys)
        order = "" if all(storey.told for storey in plan.storeys) else "; their order is a guess"
        yield f"{len(plan.storeys)} drawings are read as storeys, the lowest first: {names}{order}"
    for flight in plan.flights:
        low, high = (plan.storeys[flight.storey + k].name for k in (0, 1))
        yield f"stairs from {low} to {high}: one straight flight; which way is up is a guess"
    if plan.fixtures:
        places = {item.room for item in plan.fixtures}
        names = ", ".join(room.id for room in plan.rooms if room.number in places)
        yield f"fixtures in {names}: read from the drawing; please delete wrong ones in the editor"
    if plan.left_out:
        yield f"drawings left out, as they have no rooms with doors: {plan.left_out}"
    yield from _doubts_of_sizes(plan)
    yield from _doubts_of_rooms(plan)
    yield from _doubts_of_openings(plan)


def _doubts_of_sizes(plan: TracedPlan) -> Iterator[str]:
    """Yield a message for each written measure that does not fit the scale, with its room."""
    outside = dict.fromkeys(plan.scale.differ)
    for room in plan.rooms:
        x0, y0, x1, y1 = room.polygon.bounds
        width, depth = ((side - plan.wall_px) * plan.metres for side in (x1 - x0, y1 - y0))
        for line in room.texts:
            if line.text in plan.scale.differ:
                outside.pop(line.text, None)
                yield f"{room.id}: {line.text} is written, but {width:.2f} x {depth:.2f} m traced"
    if outside:
        yield f"measures that do not fit the scale: {', '.join(outside)}"


def _doubts_of_rooms(plan: TracedPlan) -> Iterator[str]:
    """Yield a message for each kind of doubt, with the rooms that it concerns."""
    ways = {n for o in plan.openings if o.kind != "window" for n in (o.room, o.other)}
    kinds = {
        "their use is not known": lambda r: r.types == ("Unknown",) and not r.named,
        "their use is guessed from what is drawn in them, or from their size": lambda r: (
            r.types != ("Unknown",) and not r.named
        ),
        "they may not be rooms": lambda r: r.confidence < SETTINGS.doubtful,
        "no door or passage found": lambda r: r.number not in ways,
    }
    for what, has in kinds.items():
        names = [room.id for room in plan.rooms if has(room)]
        if names:
            yield f"rooms {', '.join(names)}: {what}"


def _doubts_of_openings(plan: TracedPlan) -> Iterator[str]:
    """Yield a message for each opening of an unusual width, and for each kind with unsure ones."""
    unsure: dict[str, dict[str, None]] = {}
    names = {room.number: room.id for room in plan.rooms}
    for opening in plan.openings:
        width, place = opening.width * plan.metres, names[opening.room]
        low, high = _USUAL[opening.kind]
        if not low <= width <= high:
            yield f"a {opening.kind} of {width:.2f} m in {place}"
        if opening.confidence < SETTINGS.doubtful:
            unsure.setdefault(opening.kind, {})[place] = None
    for kind, places in unsure.items():
        yield f"{kind}s in {', '.join(places)}: unsure, please check them"


def overlay(plan: TracedPlan) -> np.ndarray:
    """Return the picture (h, w, 3) uint8 in pale, with rooms, openings and names drawn over it."""
    image = (255 - (255 - plan.picture.astype(np.float32)) * 0.6).astype(np.uint8)
    tint = image.copy()

    def pixels(points: Any) -> np.ndarray:
        picture_points = plan.frame.to_picture(np.asarray(points, float))
        return np.round(picture_points * 8).astype(np.int32)[:, None]

    thick = max(1, round(max(image.shape[:2]) / 600))
    for number, room in enumerate(plan.rooms):
        ring = pixels(room.polygon.exterior.coords[:-1])
        cv2.fillPoly(tint, [ring], _FILLS[number % len(_FILLS)], cv2.LINE_AA, 3)
    image = cv2.addWeighted(tint, 0.25, image, 0.75, 0)
    for room in plan.rooms:
        ring = pixels(room.polygon.exterior.coords[:-1])
        cv2.polylines(image, [ring], True, (200, 0, 0), thick, cv2.LINE_AA, 3)
    for opening in plan.openings:
        ends = pixels([opening.start, opening.end])
        colour = _COLOURS[opening.kind]
        cv2.polylines(image, [ends], False, colour, 3 * thick, cv2.LINE_AA, 3)
    for item in plan.fixtures:
        low, high = (pixels([end])[0, 0] for end in (item.low, item.high))
        cv2.rectangle(
            image, low.tolist(), high.tolist(), _COLOURS["fixture"], thick, cv2.LINE_AA, 3
        )
    for flight in plan.flights:
        for storey in plan.storeys[flight.storey : flight.storey + 2]:
            ends = pixels(np.array([flight.start, flight.end]) - storey.shift)[:, 0]
            foot, head = (tuple(round(float(v) / 8) for v in end) for end in ends)
            cv2.arrowedLine(image, foot, head, (120, 0, 120), 2 * thick, cv2.LINE_AA)
    for room in plan.rooms:
        spot = room.polygon.representative_point()
        x, y = plan.frame.to_picture(np.array([[spot.x, spot.y]]))[0]
        area = room.polygon.area * plan.metres**2
        size = 0.4 * thick**0.5
        at = (int(x) - 30 * thick, int(y))
        text = f"{room.id} {area:.1f} m2"
        for colour, weight in (((255, 255, 255), 3), ((120, 0, 120), 1)):
            font = cv2.FONT_HERSHEY_SIMPLEX
            cv2.putText(image, text, at, font, size, colour, weight, cv2.LINE_AA)
    return image


def traced_files(out: Path) -> tuple[Path, Path, Path]:
    """Return the files that are written with the plan `out`: plan, overlay and doubts."""
    return out, out.with_suffix(".overlay.png"), out.with_suffix(".doubts.txt")


def write_trace(
    path: str | Path,
    out: str | Path,
    *,
    metres_per_pixel: float | None = None,
    model: str | Path | None = None,
    fixture_model: str | Path | None = None,
) -> tuple[TracedPlan, list[str]]:
    """Trace a picture, write the files of :func:`traced_files`, return the plan and its doubts."""
    plan = trace_picture(
        path, metres_per_pixel=metres_per_pixel, model=model, fixture_model=fixture_model
    )
    file = Path(path).name  # without the folder: a person finds it by its name
    document = plan_document(plan, file)
    document, loose = without_loose_openings(document, file)
    house = house_of_plan(document, "traced", file=file)
    lines = list(dict.fromkeys([*doubts(plan), *loose, *validate_house(house, file=file)]))
    target, picture, notes = traced_files(Path(out))
    write_png(picture, overlay(plan))
    write_text(notes, "".join(f"{line}\n" for line in lines))
    write_json(target, document)
    return plan, lines
