"""Scenes of scene.json that are not y up or not in metres (arch@1.0.2 is z up), turned upright."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from plan2scene.plans.parse import Source
from plan2scene.plans.room_names import room_types

_UP = [0.0, 1.0, 0.0]


def upright(
    source: Source, scene: dict[str, Any], arch: dict[str, Any]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return (scene, arch) with y up and in metres; `regions` are read as `rooms`.

    The types of regions may be any names. A `|` in ids, as in "wall|room|0", becomes `_`.
    A rotation turns the axis that an arch or scene names as `up` to y; z up becomes (x, z, -y).
    An arch without `up` has that of its scene; a scene without `up` is y up.
    """
    outer = _axis(source, scene.get("up"), _UP)
    inner = _axis(source, arch.get("up"), outer)
    scale = arch.get("scaleToMeters", 1)
    scale = source.number(1 if scale is None else scale, "scaleToMeters")
    if scale <= 0:
        raise source.fault("scaleToMeters above 0", scale)
    if arch.get("rooms") is None and isinstance(arch.get("regions"), list):
        arch = {**arch, "rooms": [_region(region) for region in arch["regions"]]}
    arch = _plain_ids(arch)
    if inner != _UP or scale != 1:
        matrix = _rotation(inner)
        elements = [
            _element(source, element, matrix, scale)
            for element in source.items(arch.get("elements"), "elements")
        ]
        arch = {**arch, "elements": elements}
    if outer != _UP:
        turn = np.eye(4)
        turn[:3, :3] = _rotation(outer)
        objects = [
            _object(source, item, turn) for item in source.items(scene.get("object"), "object")
        ]
        scene = {**scene, "object": objects}
    return scene, arch


def _region(value: Any) -> Any:
    """Return a region with the room types that its names mean; `other` for an unknown name."""
    if not isinstance(value, Mapping):
        return value
    names = value.get("types", value.get("type"))
    listed = names if isinstance(names, list) else [names]
    types_of_names = [room_types(name) or ("other",) for name in listed if isinstance(name, str)]
    return {**value, "types": [name for types in types_of_names for name in types]}


def _plain_ids(value: Any, key: str = "") -> Any:
    """Return an arch with `_` for `|` in the ids of rooms, elements and holes."""
    if isinstance(value, str) and key in ("id", "roomId", "room_id"):
        return value.replace("|", "_")
    if isinstance(value, list) and key in ("elements", "rooms", "holes", "roomId", "room_id"):
        return [_plain_ids(item, key if key.startswith("room") else "") for item in value]
    if isinstance(value, dict):
        return {name: _plain_ids(item, name) for name, item in value.items()}
    return value


def _axis(source: Source, value: Any, default: list[float]) -> list[float]:
    """Return an axis as a list of one 1 or -1 and zeros."""
    if value is None:
        return default
    numbers = [value.get(k) for k in "xyz"] if isinstance(value, dict) else value
    values = [v for v in numbers if isinstance(v, int | float)] if isinstance(numbers, list) else []
    if len(values) != 3 or sorted(abs(v) for v in values) != [0, 0, 1]:
        raise source.fault("up along an axis, as [0, 1, 0] or [0, 0, 1]", repr(numbers))
    return [float(v) for v in values]


def _rotation(up: list[float]) -> np.ndarray:
    """Return the (3, 3) rotation that turns `up` to y and keeps x (if x is up: turns y to x)."""
    side = np.array([0.0, 1.0, 0.0] if up[0] else [1.0, 0.0, 0.0])
    return np.array([side, up, np.cross(side, up)])


def _element(source: Source, value: Any, matrix: np.ndarray, scale: float) -> dict[str, Any]:
    """Return an element with its points, lengths and holes in metres and y up."""
    element = dict(source.mapping(value, "an element"))
    across = np.delete(np.arange(3), int(np.argmax(np.abs(matrix[1]))))

    def point(coordinates: Any) -> list[float]:
        # Two numbers are the axes other than up, in order (coords2d).
        numbers = [
            _metres(source, v, "a point", scale) for v in source.items(coordinates, "a point")
        ]
        if len(numbers) not in (2, 3):
            raise source.fault("a point of 2 or 3 numbers", len(numbers))
        whole = np.zeros(3)
        whole[across if len(numbers) == 2 else [0, 1, 2]] = numbers
        return [float(v) + 0.0 for v in matrix @ whole]

    for key in ("points", "offset"):
        if element.get(key) is not None:
            element[key] = _deep(element[key], point)
    for key in ("height", "depth", "extra_height", "extraHeight"):
        if element.get(key) is not None:
            element[key] = _metres(source, element[key], key, scale)
    element["holes"] = [
        _hole(source, hole, scale) for hole in source.items(element.get("holes"), "holes")
    ]
    return element


def _deep(value: Any, point: Callable[[Any], list[float]], depth: int = 0) -> Any:
    """Apply `point` to a point, to a list of points or to a list of such lists."""
    nested = isinstance(value, list) and bool(value) and isinstance(value[0], list)
    return (
        [_deep(item, point, depth + 1) for item in value] if nested and depth < 3 else point(value)
    )


def _hole(source: Source, value: Any, scale: float) -> dict[str, Any]:
    """Return a hole with its box in metres (a box is along the wall: no axis to turn)."""
    hole = dict(source.mapping(value, "a hole"))
    box = source.mapping(hole.get("box"), "a hole's box")
    hole["box"] = {
        key: [_metres(source, v, "a hole's box", scale) for v in source.items(box.get(key), key)]
        for key in ("min", "max")
    }
    return hole


def _object(source: Source, value: Any, turn: np.ndarray) -> Any:
    """Return an object with its transform (16 numbers, column by column) turned."""
    transform = value.get("transform") if isinstance(value, Mapping) else None
    if not isinstance(transform, Mapping):
        return value
    data = transform.get("data")
    if not isinstance(data, list) or len(data) != 16:
        return value
    numbers = [source.number(v, "an object's transform") for v in data]
    turned = (turn @ np.array(numbers).reshape(4, 4).T).T.ravel().tolist()
    return {**value, "transform": {**transform, "data": turned}}


def _metres(source: Source, value: Any, what: str, scale: float) -> float:
    """Return a number in the file's unit as metres."""
    try:
        scaled = value * scale if type(value) in (int, float) else value
    except OverflowError:
        scaled = float("inf")
    return source.number(scaled, what)
