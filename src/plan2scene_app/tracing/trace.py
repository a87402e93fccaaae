"""A picture of a plan to a plan: labels, regions, polygons, openings, texts, scale, doubts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from shapely.geometry import Polygon

from plan2scene.weights import MODELS
from plan2scene_app.tracing.frame import Frame, first_scale, main_direction, straightened, whole
from plan2scene_app.tracing.gaps import with_passages
from plan2scene_app.tracing.labels import MODEL, ROOM
from plan2scene_app.tracing.lettering import TextLine, read_lines, reader_installed, without_text
from plan2scene_app.tracing.openings import TracedOpening, find_openings
from plan2scene_app.tracing.outlines import room_polygons
from plan2scene_app.tracing.picture import (
    dark_on_light,
    how_sure,
    read_plan_picture,
    refuse_other_pictures,
)
from plan2scene_app.tracing.regions import Regions, find_regions, structure_of
from plan2scene_app.tracing.rooms import TracedRoom, describe_rooms, without_inner_windows
from plan2scene_app.tracing.scale import RoomSize, Scale, chain_evidence, find_scale, room_evidence
from plan2scene_app.tracing.segmenter import PlanSegmenter, load_plan_segmenter

#: Views that the plan is seen in, at first and once it is straight.
FIRST_VIEWS, VIEWS = 2, 4
#: Metres: what is narrower than this is no opening.
LEAST_WIDTH = {"door": 0.45, "window": 0.3, "passage": 0.5}
#: Metres up to which a gap between two rooms is a door rather than a passage.
WIDEST_DOOR = 1.2


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
    frame, probabilities, regions = _seen(without_text(page, texts), segmenter)
    polygons = room_polygons(regions) if regions.count else {}
    openings = find_openings(regions, polygons, probabilities)
    sure = how_sure(probabilities, regions)
    refuse_other_pictures(path, picture.image, sure, polygons, len(openings))
    lines = _in_frame(texts, frame)
    rooms = describe_rooms(regions, polygons, probabilities, lines)
    if metres_per_pixel is not None:
        given = metres_per_pixel * picture.shrunk / frame.zoom
        scale = Scale(given, 1.0, "as given")
    else:
        scale = _scale(regions, rooms, openings, lines)
    widest = WIDEST_DOOR / scale.metres_per_pixel
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


def _seen(image: np.ndarray, segmenter: PlanSegmenter) -> tuple[Frame, np.ndarray, Regions]:
    """Return the straight frame of a picture, its probabilities and regions."""
    first = whole(image, segmenter.long_side)
    rough = segmenter.probabilities(first.image, views=FIRST_VIEWS)
    structure = structure_of(rough)
    if not (structure == ROOM).any():
        return first, rough, find_regions(structure, segmenter.long_side / 12)
    frame = straightened(image, first, structure, main_direction(1 - rough[ROOM:].sum(0)))
    probabilities = segmenter.probabilities(frame.image, views=VIEWS)
    structure = structure_of(probabilities)
    ppm = first_scale(structure)
    return frame, probabilities, find_regions(with_passages(structure, ppm), ppm)


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
    for room in rooms:
        rows, columns = np.nonzero(regions.floors == room.number)
        sides = float(np.ptp(columns) + 1), float(np.ptp(rows) + 1)
        evidence += room_evidence(RoomSize(float(areas[room.number]), sides, room.texts))
    xs, ys = _walls([room.polygon for room in rooms])
    for line in lines:
        found = chain_evidence(line, xs, ys)
        if found is not None:
            evidence.append(found)
    doors = [o.width for o in openings if o.kind == "door" and o.confidence > 0.5]
    return find_scale(evidence, doors, [float(areas[room.number]) for room in rooms])


def _walls(polygons: Sequence[Polygon]) -> tuple[list[float], list[float]]:
    """Return the places of walls along x and along y."""
    corners = np.concatenate([np.array(p.exterior.coords) for p in polygons])
    xs, ys = (sorted(set(np.round(corners[:, axis], 1).tolist())) for axis in (0, 1))
    return xs, ys
