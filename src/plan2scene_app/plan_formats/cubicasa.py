"""Reader of SVG plans with the classes of CubiCasa: Space, Wall, Door, Window, FixedFurniture.

Pixels, x right, y down. The scale is given by the user, or read from a page size with a unit, or
from areas or sides written in the rooms.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from statistics import median
from xml.etree.ElementTree import Element

import numpy as np
from shapely.affinity import scale as scaled
from shapely.geometry import Polygon

from plan2scene.house import USUAL, House, IconBox
from plan2scene.plans.parse import MAX_ROOMS, Source
from plan2scene.plans.plan_file import PlanFormat, Unscaled
from plan2scene_app.plan_formats.axes import MAX_AXES, SETTINGS, NearestAxis, axis_of_area
from plan2scene_app.plan_formats.containers import parse_xml
from plan2scene_app.plan_formats.drawing import (
    Drawing,
    DrawnRoom,
    house_of_drawing,
    largest_storey,
)
from plan2scene_app.plan_formats.measures import read_areas, read_sides

_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_TRANSFORM = re.compile(r"(matrix|translate|scale|rotate)\s*\(([^)]*)\)")
_LENGTH = re.compile(r"\s*(\d+\.?\d*|\.\d+)\s*(mm|cm|m|in)\s*")
_METRES = {"mm": 0.001, "cm": 0.01, "m": 1.0, "in": 0.0254}
#: Deepest nesting of groups.
MAX_DEPTH = 100
#: Largest length of the text of a polygon's points.
MAX_POINTS_TEXT = 200_000
#: Smallest and largest scale in metres a pixel.
SCALES = (1e-5, 1.0)
#: Largest number of walls, rooms, openings and pieces of furniture of a page.
MAX_ITEMS = 2 * (MAX_AXES + MAX_ROOMS)
_KINDS = ("Space", "Wall", "Railing", "Door", "Window", "FixedFurniture")


@dataclass
class _Storey:
    """Areas (x, y) in pixels: (kind, further class words, area, text inside)."""

    name: str
    items: list[tuple[str, list[str], Polygon, str]] = field(default_factory=list)

    def of(self, *kinds: str) -> Iterator[tuple[list[str], Polygon, str]]:
        return ((words, area, text) for kind, words, area, text in self.items if kind in kinds)

    def floor(self) -> float:
        return sum(area.area for _, area, _ in self.of("Space"))


def house_of_cubicasa(
    content: bytes, house_id: str, metres_per_pixel: float | None, *, file: str = ""
) -> House:
    """Return the house of an SVG plan: the storey with the most floor.

    Raises InputError for an SVG without such classes, and if no scale is given or written.
    """
    source = Source(file, house_id)
    root = parse_xml(source, content, doctype=True)
    storey = _storey(source, root)
    m = metres_per_pixel or _page_scale(root) or _written_scale(source, storey)
    if m is None or not SCALES[0] < m <= SCALES[1]:
        expected = f"metres_per_pixel up to {SCALES[1]:g}, or areas or sides written in the rooms"
        raise source.fault(expected, str(m))
    return replace(house_of_drawing(source, _drawing(source, storey, m)), heights=USUAL)


def size_of_cubicasa(content: bytes, house_id: str, *, file: str = "") -> tuple[float, float]:
    """Return width and depth in pixels of what :func:`house_of_cubicasa` reads."""
    source = Source(file, house_id)
    storey = _storey(source, parse_xml(source, content, doctype=True))
    bounds = np.array([area.bounds for _, area, _ in storey.of("Space", "Wall")])
    width, depth = bounds[:, 2:].max(axis=0) - bounds[:, :2].min(axis=0)
    return float(width), float(depth)


def _storey(source: Source, root: Element) -> _Storey:
    """Return the storey with the most floor."""
    storeys = _read(source, root)
    sizes = [(storey.name, storey.floor()) for storey in storeys]
    storey = storeys[largest_storey(source, sizes)]
    if not any(True for _ in storey.of("Space", "Wall")):
        raise source.fault("SVG groups of class Space or Wall, as CubiCasa has them", "none")
    return storey


def _drawing(source: Source, storey: _Storey, m: float) -> Drawing:
    """Return a storey's areas in metres."""

    def metric(area: Polygon) -> Polygon:
        return scaled(area, m, m, origin=(0, 0))

    drawing = Drawing()
    for words, area, _ in storey.of("Space"):
        ring = source.ring([(x * m, y * m) for x, y in area.exterior.coords], " ".join(words))
        drawing.rooms.append(DrawnRoom(" ".join(words), (ring,), called=False))
    for _, area, _ in storey.of("Wall", "Railing"):
        axis = axis_of_area(metric(area))
        drawing.axes += [] if axis is None else [axis]
    nearest = NearestAxis(drawing.axes)
    for kind in ("Door", "Window"):
        for words, area, _ in storey.of(kind):
            name = f"opening_{len(drawing.openings)}"
            leafless = kind == "Door" and bool({"None", "Opening"} & set(words))
            segment = nearest.segment(metric(area), name, "passage" if leafless else kind.lower())
            drawing.openings += [] if segment is None else [segment]
    for words, area, _ in storey.of("FixedFurniture"):
        x0, z0, x1, z1 = metric(area).bounds
        drawing.icons.append(IconBox(" ".join(words)[:100] or "furniture", (x0, z0), (x1, z1)))
    return drawing


def _read(source: Source, root: Element) -> list[_Storey]:
    """Return a storey for each group of class Floor, and one for the areas outside all of them."""
    outside = _Storey("the page")
    storeys = [outside]
    queue = [(root, np.eye(3), outside, 0)]
    count = 0
    while queue:
        element, parent_matrix, storey, depth = queue.pop()
        if depth > MAX_DEPTH:
            raise source.fault(f"SVG groups at most {MAX_DEPTH} deep", "deeper")
        matrix = parent_matrix @ _matrix(source, element.get("transform", ""))
        words = f"{element.get('class') or element.get('id') or ''}".split()
        if "Floor" in words:
            storey = _Storey(element.get("id") or f"floor {len(storeys)}")
            storeys.append(storey)
        kind = next((word for word in words[:1] if word in _KINDS), "")
        area = _area(source, element, matrix) if kind else None
        if area is not None:
            storey.items.append((kind, words[1:], area, "\n".join(element.itertext())[:500]))
            count += 1
        if count > MAX_ITEMS:
            raise source.fault(f"at most {MAX_ITEMS} walls and rooms", "more")
        queue += [(child, matrix, storey, depth + 1) for child in reversed(element)]
    return [storey for storey in storeys if storey.items] or [outside]


def _area(source: Source, element: Element, matrix: np.ndarray) -> Polygon | None:
    """Return the area of the polygon that is a child of an element or of its BoundaryPolygon."""
    below = list(element)
    below += [item for child in below if child.get("class") == "BoundaryPolygon" for item in child]
    shape = next((item for item in below if item.tag.rsplit("}")[-1] == "polygon"), None)
    if shape is None:
        return None
    text = shape.get("points", "")
    if len(text) > MAX_POINTS_TEXT:
        raise source.fault(f"at most {MAX_POINTS_TEXT} letters of a polygon's points", len(text))
    numbers = _numbers(source, text)
    if len(numbers) < 6 or len(numbers) % 2:
        raise source.fault("a polygon of at least 3 points", f"{len(numbers)} numbers")
    points = np.column_stack([np.reshape(numbers, (-1, 2)), np.ones(len(numbers) // 2)])
    polygon = Polygon((points @ matrix.T)[:, :2])
    whole = polygon if polygon.is_valid else polygon.convex_hull
    return whole if isinstance(whole, Polygon) and whole.area > 0 else None


def _numbers(source: Source, text: str) -> list[float]:
    values = [float(value) for value in _NUMBER.findall(text)]
    if not all(abs(value) < 1e7 for value in values):
        raise source.fault("coordinates below 1e7", "more")
    return values


def _matrix(source: Source, text: str) -> np.ndarray:
    """Return the (3, 3) matrix of a transform attribute."""
    total = np.eye(3)
    for name, inside in _TRANSFORM.findall(text):
        v = _numbers(source, inside)
        matrix = np.eye(3)
        if name == "matrix" and len(v) == 6:
            matrix[:2] = [[v[0], v[2], v[4]], [v[1], v[3], v[5]]]
        elif name == "translate" and v:
            matrix[:2, 2] = [v[0], v[1] if len(v) > 1 else 0.0]
        elif name == "scale" and v:
            matrix[0, 0], matrix[1, 1] = v[0], v[-1]
        elif name == "rotate" and v:
            c, s = np.cos(np.radians(v[0])), np.sin(np.radians(v[0]))
            x, y = (v[1], v[2]) if len(v) == 3 else (0.0, 0.0)
            matrix[:2] = [[c, -s, x - c * x + s * y], [s, c, y - s * x - c * y]]
        else:
            raise source.fault("an SVG transform", f"{name}({inside[:40]})")
        total = total @ matrix
    return total


def _page_scale(root: Element) -> float | None:
    """Return metres a pixel if the page is as large as the flat, else None.

    Such a page has a viewBox, and a width of more than 2 m with a unit; paper is smaller.
    """
    length = _LENGTH.fullmatch(root.get("width", ""))
    box = _NUMBER.findall(root.get("viewBox", ""))
    if length is None or len(box) != 4 or float(box[2]) <= 0:
        return None
    width = float(length[1]) * _METRES[length[2]]
    return width / float(box[2]) if width > 2.0 else None


def _written_scale(source: Source, storey: _Storey) -> float | None:
    """Return metres a pixel by the sizes written in rooms; InputError if they do not agree."""
    scales = []
    for _, area, text in storey.of("Space"):
        if area.area > 0:
            scales += [float(np.sqrt(square / area.area)) for square, _ in read_areas(text)]
            scales += _by_sides(area, text)
    if not scales:
        return None
    middle = median(scales)
    agree = [scale for scale in scales if abs(scale - middle) <= SETTINGS.agreement * middle]
    if len(agree) <= len(scales) / 2:
        raise source.fault("sizes written in the rooms that agree", f"scales {scales[:5]}")
    source.warn("metres_per_pixel", f"none; {middle:.5f} read from {len(scales)} written sizes")
    return middle


def _by_sides(area: Polygon, text: str) -> list[float]:
    """Return metres a pixel by each two sides written in a room that fit the room's shape."""
    x0, y0, x1, y1 = area.bounds
    fitting = []
    for line in text.splitlines():
        for sides in read_sides(line):
            drawn_sides = sorted((x1 - x0, y1 - y0))
            low, high = (
                side / pixels for side, pixels in zip(sorted(sides), drawn_sides, strict=True)
            )
            if max(low, high) <= (1 + SETTINGS.agreement) * min(low, high):
                fitting.append(float(np.sqrt(low * high)))
    return fitting


PLAN_FORMAT = PlanFormat(
    "CubiCasa SVG",
    lambda plan: plan.text.lstrip().startswith("<") and "<svg" in plan.text[:5000],
    lambda plan: house_of_cubicasa(
        plan.text.encode(), plan.house_id, plan.metres_per_pixel, file=str(plan.path)
    ),
    suffixes=(".svg",),
    look=lambda plan: Unscaled("pixel", size_of_cubicasa(plan.text.encode(), plan.house_id)),
    lacks_heights=lambda _: True,
)
