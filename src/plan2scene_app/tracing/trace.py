"""A picture of a plan to a plan in metres, with its doubts and an overlay to check it by.

Labels, regions, polygons, openings, texts, scale: each step is a module of this package.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from shapely.geometry import Polygon

from plan2scene.images import write_png
from plan2scene.io import write_json, write_text
from plan2scene.plans.plan_json import FORMAT, house_of_plan
from plan2scene.plans.room_names import room_types
from plan2scene.plans.validate import validate_house
from plan2scene.plugins import pip_command
from plan2scene.weights import MODELS
from plan2scene_app.plan_formats.axes import HEIGHTS
from plan2scene_app.plan_formats.measures import sides_in_feet
from plan2scene_app.tracing.ink import with_drawn_doors
from plan2scene_app.tracing.lettering import TextLine, read_lines, reader_installed, without_text
from plan2scene_app.tracing.openings import TracedOpening, find_openings
from plan2scene_app.tracing.picture import (
    Frame,
    dark_on_light,
    first_scale,
    how_sure,
    main_direction,
    read_plan_picture,
    refuse_other_pictures,
    straightened,
    whole,
)
from plan2scene_app.tracing.regions import Regions, find_regions, structure_of, with_passages
from plan2scene_app.tracing.rooms import (
    TracedRoom,
    describe_rooms,
    room_polygons,
    without_inner_windows,
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
from plan2scene_app.tracing.settings import MODEL, ROOM, SETTINGS
from plan2scene_app.tracing.thin_walls import with_thin_walls

#: Metres: what is narrower than this is no opening.
LEAST_WIDTH = {
    "door": SETTINGS.least_door,
    "window": SETTINGS.least_window,
    "passage": SETTINGS.least_passage,
}


@dataclass(frozen=True)
class TracedPlan:
    """What was read of a picture; lengths in pixels of the frame until `metres` of one is used."""

    picture: np.ndarray  #: (h, w, 3) uint8 as worked on
    frame: Frame
    rooms: tuple[TracedRoom, ...]
    openings: tuple[TracedOpening, ...]
    scale: Scale  #: of the frame's pixels
    wall_px: float
    shrunk: float  #: pixels of the file for one of the picture
    sure: float  #: mean probability of what was found
    read: bool  #: whether text was read

    @property
    def metres(self) -> float:
        """Metres of a pixel of the frame."""
        return self.scale.metres_per_pixel

    @property
    def file_metres(self) -> float:
        """Metres of a pixel of the file."""
        return self.metres * self.frame.zoom / self.shrunk


def trace_picture(
    path: str | Path, *, metres_per_pixel: float | None = None, model: str | Path | None = None
) -> TracedPlan:
    """Return the plan that a picture shows.

    `metres_per_pixel` of the file's own pixels is believed before anything written. Raises
    InputError for what is no picture of a plan.
    """
    picture = read_plan_picture(path)
    segmenter = load_plan_segmenter(model or MODELS / f"{MODEL}.safetensors")
    page = dark_on_light(picture.image)
    read = reader_installed()
    texts = read_lines(page) if read else []
    frame, probabilities, regions = _seen(without_text(page, texts), segmenter, texts)
    polygons = room_polygons(regions) if regions.count else {}
    openings = find_openings(regions, polygons, probabilities)
    sure = how_sure(probabilities, regions)
    refuse_other_pictures(path, picture.image, sure, polygons, len(openings))
    lines = _in_frame(texts, frame)
    rooms = describe_rooms(regions, polygons, probabilities, lines)
    if metres_per_pixel is not None:
        frame_metres = metres_per_pixel * picture.shrunk / frame.zoom
        scale = Scale(frame_metres, 1.0, "as given")
    else:
        scale = _scale(regions, rooms, openings, lines)
    widest = SETTINGS.widest_door / scale.metres_per_pixel
    openings = without_inner_windows(openings, rooms, widest)
    kept = tuple(o for o in openings if o.width * scale.metres_per_pixel >= LEAST_WIDTH[o.kind])
    return TracedPlan(
        picture.image,
        frame,
        tuple(rooms),
        kept,
        scale,
        regions.wall_px,
        picture.shrunk,
        sure,
        read,
    )


def _seen(
    image: np.ndarray, segmenter: PlanSegmenter, texts: Sequence[TextLine]
) -> tuple[Frame, np.ndarray, Regions]:
    """Return the straight frame of a picture, its probabilities and regions."""
    first = whole(image, segmenter.long_side)
    rough = segmenter.probabilities(first.image, views=SETTINGS.first_views)
    structure = structure_of(rough)
    if not (structure == ROOM).any():
        return first, rough, find_regions(structure, segmenter.long_side / 12)
    frame = straightened(image, first, structure, main_direction(1 - rough[ROOM:].sum(0)))
    probabilities = segmenter.probabilities(frame.image, views=SETTINGS.views)
    structure = structure_of(probabilities)
    ppm = first_scale(structure)
    lines = _in_frame(texts, frame)
    names = [line.middle for line in lines if room_types(line.text)]
    feet = sides_in_feet(line.text for line in lines)
    sizes = [(*line.middle, area) for line in lines for area in told_area(line.text, feet=feet)]
    divided, ppm = with_thin_walls(structure, frame.image, names, sizes, ppm)
    if divided is structure:
        divided = with_passages(with_drawn_doors(structure, frame.image, ppm), ppm)
    return frame, probabilities, find_regions(divided, ppm)


def _in_frame(lines: Sequence[TextLine], frame: Frame) -> list[TextLine]:
    """Return texts of the picture in the frame's pixels."""
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
) -> Scale:
    """Return the scale that texts, doors and rooms agree on."""
    areas = np.bincount(regions.floors.ravel(), minlength=regions.count + 1).astype(float)
    evidence = []
    feet = sides_in_feet(line.text for line in lines)
    for room in rooms:
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
    """Return the places of walls along x and along y."""
    corners = np.concatenate([np.array(p.exterior.coords) for p in polygons])
    xs, ys = (sorted(set(np.round(corners[:, axis], 1).tolist())) for axis in (0, 1))
    return xs, ys


#: Metres that doors and windows of homes have.
_USUAL = {"door": (0.5, 2.6), "window": (0.3, 6.0), "passage": (0.5, 6.0)}
_COLOURS = {"door": (0, 150, 60), "window": (20, 90, 235), "passage": (240, 140, 0)}
_FILLS = ((230, 90, 80), (90, 160, 230), (110, 190, 110), (230, 180, 70), (170, 120, 210))


def plan_origin(plan: TracedPlan) -> np.ndarray:
    """Return the upper left corner of the rooms (x, y) in pixels of the frame."""
    corners = np.concatenate([np.array(r.polygon.exterior.coords) for r in plan.rooms])
    return np.asarray(corners.min(0))


def place_in_picture(plan: TracedPlan, file: str) -> dict[str, Any]:
    """Return where the plan's metres lie in the file's pixels (`picture` in the schema)."""
    corner = plan_origin(plan)
    there = plan.frame.to_picture(np.array([corner, corner + [1, 0]])) * plan.shrunk
    step = there[1] - there[0]
    return {
        "file": file,
        "origin": [round(float(v), 2) for v in there[0]],
        "metres_per_pixel": round(plan.file_metres, 7),
        "turned": round(float(np.degrees(np.arctan2(step[1], step[0]))), 3),
    }


def plan_document(plan: TracedPlan, file: str = "") -> dict[str, Any]:
    """Return the plan as this program's plan JSON, in metres from its upper left corner.

    With the name of its picture's `file` it tells where it lies in that.
    """
    origin = plan_origin(plan)

    def metric(point: Any) -> list[float]:
        return [round(float(v), 3) for v in (np.asarray(point) - origin) * plan.metres]

    rooms = []
    for room in plan.rooms:
        entry: dict[str, Any] = {"id": room.id, "types": list(room.types)}
        entry["polygon"] = [metric(p) for p in room.polygon.exterior.coords[:-1]]
        holes = [[metric(p) for p in ring.coords[:-1]] for ring in room.polygon.interiors]
        rooms.append(entry | ({"holes": holes} if holes else {}))
    openings = []
    for number, opening in enumerate(plan.openings):
        bottom, top = HEIGHTS[opening.kind]
        openings.append(
            {
                "id": f"{opening.kind}_{number}",
                "kind": opening.kind,
                "from": metric(opening.start),
                "to": metric(opening.end),
                "bottom": bottom,
                "top": top,
            }
        )
    depth = round(float(np.clip(plan.wall_px * plan.metres, 0.05, 0.5)), 3)
    place = {"picture": place_in_picture(plan, file)} if file else {}
    return {
        "format": FORMAT,
        "version": 1,
        **place,
        "wall_depth": depth,
        "rooms": rooms,
        "openings": openings,
    }


def doubts(plan: TracedPlan) -> Iterator[str]:
    """Yield a line for everything that is a guess or unlikely."""
    scale = plan.scale
    if scale.confidence < SETTINGS.sure:
        centimetres = 100 * plan.file_metres
        yield (
            f"the scale is {scale.source} ({centimetres:.3g} cm a pixel, {scale.confidence:.0%} "
            "sure): give --metres-per-pixel"
        )
    if plan.sure < SETTINGS.busy[0]:
        yield f"the picture as a whole: {plan.sure:.0%} sure of what it shows"
    if not plan.read:
        yield f"no text is read: {pip_command('plan2scene[trace]')}"
    if scale.differ:
        yield f"measures that do not fit the scale: {', '.join(scale.differ)}"
    yield from _doubts_of_rooms(plan)
    yield from _doubts_of_openings(plan)


def _doubts_of_rooms(plan: TracedPlan) -> Iterator[str]:
    """Yield a line for each kind of doubt, with the rooms that have it."""
    ways = {n for o in plan.openings if o.kind != "window" for n in (o.room, o.other)}
    kinds = {
        "nothing tells what they are": lambda r: r.types == ("Unknown",),
        "their furniture alone tells what they are": lambda r: (
            r.types != ("Unknown",) and not r.named
        ),
        "hardly sure that they are rooms": lambda r: r.confidence < SETTINGS.doubtful,
        "no door or passage found": lambda r: r.number not in ways,
    }
    for what, has in kinds.items():
        names = [room.id for room in plan.rooms if has(room)]
        if names:
            yield f"rooms {', '.join(names)}: {what}"


def _doubts_of_openings(plan: TracedPlan) -> Iterator[str]:
    """Yield a line for each opening of an odd width, and one for those that are hardly sure."""
    unsure = []
    for number, opening in enumerate(plan.openings):
        width = opening.width * plan.metres
        low, high = _USUAL[opening.kind]
        place = next(room.id for room in plan.rooms if room.number == opening.room)
        if not low <= width <= high:
            yield f"a {opening.kind} of {width:.2f} m in {place}"
        if opening.confidence < SETTINGS.doubtful:
            unsure.append(f"{opening.kind}_{number} ({place})")
    if unsure:
        yield f"hardly sure openings: {', '.join(unsure)}"


def overlay(plan: TracedPlan) -> np.ndarray:
    """Return the picture (h, w, 3) uint8, paled, with rooms, openings and names over it."""
    image = (255 - (255 - plan.picture.astype(np.float32)) * 0.6).astype(np.uint8)
    tint = image.copy()

    def pixels(points: Any) -> np.ndarray:
        there = plan.frame.to_picture(np.asarray(points, float))
        return np.round(there * 8).astype(np.int32)[:, None]

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
    """Return what is written for a plan `out`: itself, the overlay, the doubts."""
    return out, out.with_suffix(".overlay.png"), out.with_suffix(".doubts.txt")


def write_trace(
    path: str | Path,
    out: str | Path,
    *,
    metres_per_pixel: float | None = None,
    model: str | Path | None = None,
) -> tuple[TracedPlan, list[str]]:
    """Trace a picture; write what :func:`traced_files` names. Return plan and lines of doubt."""
    plan = trace_picture(path, metres_per_pixel=metres_per_pixel, model=model)
    document = plan_document(plan, Path(path).name)
    house = house_of_plan(document, "traced", file=str(path))
    lines = list(dict.fromkeys([*doubts(plan), *validate_house(house, file=path)]))
    target, picture, notes = traced_files(Path(out))
    write_png(picture, overlay(plan))
    write_text(notes, "".join(f"{line}\n" for line in lines))
    write_json(target, document)
    return plan, lines
