"""Reader of layouts as in the Zillow Indoor Dataset: a floor of zind_data.json.

Rooms come from `redraw` (the cleaned plan), else from the first primary panorama of each complete
room in `merger`. Plan units times `scale_meters_per_coordinate` are metres; the plan's y goes up:
(x, y) becomes (x, -y).
"""

from __future__ import annotations

from collections.abc import Iterator
from statistics import median
from typing import Any

import numpy as np

from plan2scene.house import DEFAULT_HEIGHT, House
from plan2scene.plans.openings import Segment
from plan2scene.plans.parse import MAX_CORNERS, Source
from plan2scene.plans.plan_file import PlanFormat, Unscaled
from plan2scene_app.plan_formats.axes import HEIGHTS
from plan2scene_app.plan_formats.drawing import (
    Drawing,
    DrawnRoom,
    house_of_drawing,
    largest_storey,
)

_KINDS = {"doors": "door", "windows": "window", "openings": "passage"}


def is_zind(document: Any) -> bool:
    """Return whether a JSON document holds layouts as in ZInD."""
    return isinstance(document, dict) and (
        isinstance(document.get("redraw"), dict) or isinstance(document.get("merger"), dict)
    )


def house_of_zind(
    document: Any, house_id: str, metres_per_unit: float | None = None, *, file: str = ""
) -> House:
    """Return the house of the floor with the most floor area.

    `metres_per_unit`, if given, replaces the file's scale. InputError if a floor has neither.
    """
    source = Source(file, house_id)
    parts = {
        key: source.mapping(document.get(key) or {}, key)
        for key in ("redraw", "merger", "scale_meters_per_coordinate")
    }
    names = dict.fromkeys([*parts["redraw"], *parts["merger"]])
    drawings = {name: _floor(source, parts, name, metres_per_unit) for name in names}
    drawings = {name: drawing for name, drawing in drawings.items() if drawing.rooms}
    if not drawings:
        raise source.fault("rooms in 'redraw' or 'merger'", "none")
    sizes = [(name, drawing.floor()) for name, drawing in drawings.items()]
    chosen = list(drawings)[largest_storey(source, sizes)]
    return house_of_drawing(source, drawings[chosen])


def _floor(
    source: Source, parts: dict[str, dict[str, Any]], name: str, chosen: float | None
) -> Drawing:
    """Return the drawing of one floor."""
    written = parts["scale_meters_per_coordinate"].get(name)
    redraw = source.mapping(parts["redraw"].get(name) or {}, "redraw")
    merger = source.mapping(parts["merger"].get(name) or {}, "merger")
    panoramas = list(_panoramas(source, merger))
    if not redraw and not panoramas:
        return Drawing()
    if chosen is None and written is None:
        expected = f"scale_meters_per_coordinate of {name}, or metres_per_pixel for its unit"
        raise source.fault(expected, "none")
    m = source.number(written, "scale_meters_per_coordinate") if chosen is None else chosen
    if m <= 0:
        raise source.fault("scale_meters_per_coordinate above 0", m)
    heights = [
        source.number(pano["ceiling_height"], "ceiling_height") * _placing(source, pano)[0] * m
        for _, pano in panoramas
        if pano.get("ceiling_height") is not None
    ]
    drawing = Drawing(height=median([h for h in heights if h > 0] or [DEFAULT_HEIGHT]))
    for room in redraw.values():
        item = source.mapping(room, "a room")
        pins = [source.mapping(pin, "a pin") for pin in source.items(item.get("pins"), "pins")]
        label = " / ".join(str(pin.get("label", "")) for pin in pins)[:100]
        _add_room(source, drawing, item, label, np.eye(2) * m, np.zeros(2), 2)
    if not drawing.rooms:
        for label, pano in panoramas:
            layout = pano.get("layout_raw") or pano.get("layout_complete")
            scale, turn, move = _placing(source, pano)
            item = source.mapping(layout, "layout_raw")
            _add_room(source, drawing, item, label, turn * scale * m, move * m, 3)
    return drawing


def _panoramas(source: Source, merger: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield (label, panorama) for each complete room: the first primary one, else the first."""
    for complete in merger.values():
        panoramas = [
            source.mapping(pano, "a panorama")
            for partial in source.mapping(complete, "a complete room").values()
            for pano in source.mapping(partial, "a partial room").values()
        ]
        panoramas.sort(key=lambda pano: not pano.get("is_primary"))
        if panoramas:
            yield str(panoramas[0].get("label", ""))[:100], panoramas[0]


def _placing(source: Source, pano: dict[str, Any]) -> tuple[float, np.ndarray, np.ndarray]:
    """Return scale, (2, 2) matrix and (2,) translation of a panorama in the plan."""
    item = source.mapping(pano.get("floor_plan_transformation"), "floor_plan_transformation")
    angle = np.radians(source.number(item.get("rotation"), "rotation"))
    c, s = np.cos(angle), np.sin(angle)
    move = [source.number(v, "translation") for v in source.items(item.get("translation"), "t")]
    if len(move) != 2:
        raise source.fault("a translation of 2 numbers", len(move))
    return source.number(item.get("scale"), "scale"), np.array([[c, -s], [s, c]]), np.array(move)


def _points(
    source: Source, value: Any, matrix: np.ndarray, move: np.ndarray
) -> list[tuple[float, float]]:
    """Return points in metres, (x, -y)."""
    points = []
    items = source.items(value, "points")
    if len(items) > MAX_CORNERS:
        raise source.fault(f"at most {MAX_CORNERS} points of a room", len(items))
    for item in items:
        pair = [source.number(v, "a coordinate") for v in source.items(item, "a point")]
        if len(pair) != 2:
            raise source.fault("points of 2 numbers", len(pair))
        x, y = matrix @ np.array(pair) + move
        points.append((float(x), -float(y)))
    return points


def _add_room(
    source: Source,
    drawing: Drawing,
    room: dict[str, Any],
    label: str,
    matrix: np.ndarray,
    move: np.ndarray,
    step: int,
) -> None:
    """Add a room and its openings, which have `step` points each; a third one is (bottom, top)."""
    ring = source.outline(_points(source, room.get("vertices"), matrix, move), label[:40])
    drawing.add_room(DrawnRoom(label, (ring,)))
    for key, kind in _KINDS.items():
        raw = source.items(room.get(key), key)
        if raw and isinstance(raw[0], list) and raw[0] and isinstance(raw[0][0], list):
            raw = [point for item in raw for point in source.items(item, key)]
        for k in range(0, len(raw) - 1, step):
            start, end = _points(source, raw[k : k + 2], matrix, move)
            if not drawing.shows(start, end, kind):
                name = f"opening_{len(drawing.openings)}"
                drawing.openings.append(Segment(name, kind, start, end, *HEIGHTS[kind]))


PLAN_FORMAT = PlanFormat(
    "ZInD JSON",
    lambda plan: is_zind(plan.document),
    lambda plan: house_of_zind(
        plan.document, plan.house_id, plan.metres_per_pixel, file=str(plan.path)
    ),
    suffixes=(".json",),
    look=lambda _: Unscaled("unit"),
)
