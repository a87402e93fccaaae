"""Reader of IFC models by ifcopenshell (the extra `formats`): storeys, spaces, walls, openings.

Triangles of bodies are projected onto the plan. Metres; IFC's z goes up: (x, y, z) becomes (x, -y).
"""

from __future__ import annotations

import pickle
import re
import subprocess
import sys
import tempfile
import traceback
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from shapely import area as areas_of
from shapely import polygons, unary_union
from shapely.geometry import Polygon

from plan2scene.house import House, Stairs
from plan2scene.plans.levels import STAIRS
from plan2scene.plans.parse import MAX_COORDINATE, MAX_ROOMS, Source
from plan2scene.plans.plan_file import PlanFormat
from plan2scene_app.bound_process import run_bound
from plan2scene_app.plan_formats.axes import MAX_AXES, SETTINGS, NearestAxis, axis_of_area
from plan2scene_app.plan_formats.drawing import Drawing, DrawnRoom, DrawnStorey, house_of_storeys

#: Largest number of bytes of a model, and of triangles of one body.
MAX_BYTES = 200_000_000
MAX_TRIANGLES = 20_000
#: Largest number of triangles of a model, and largest absolute component of an IfcDirection.
MAX_ALL_TRIANGLES, MAX_RATIO = 1_000_000, 1e6
#: Largest number of letters of a file's header.
MAX_HEAD = 100_000
_SCHEMA = re.compile(r"(FILE_SCHEMA\s*\(\s*\(\s*')([^']*)(')", re.IGNORECASE)


@dataclass(frozen=True)
class _Body:
    """The body of a product: its area in the plan (x, -y), bottom and top in metres, its points.

    `points` are (n, 3): x and -y in the plan, and the height.
    """

    area: Polygon
    low: float
    high: float
    points: np.ndarray = field(repr=False)


def is_ifc(head: bytes) -> bool:
    """Return whether a file begins as a STEP file does: IFC models are STEP files."""
    return head.lstrip().startswith(b"ISO-10303-21")


def house_of_ifc(path: Path, house_id: str) -> House:
    """Return the house of an IFC model with its storeys, each at the height of its floors.

    Some damaged models make ifcopenshell crash, so it reads them in a process of its own. Raises
    InputError if it crashes, and for a model without spaces and walls.
    """
    with tempfile.TemporaryDirectory() as folder:
        answer = Path(folder) / "answer"
        command = [sys.executable, "-m", __name__, str(path), house_id, str(answer)]
        if code := run_bound(command, stderr=subprocess.DEVNULL):
            found = f"one on which its reader crashes (exit code {code})"
            raise Source(str(path), house_id).fault("an IFC model that can be read", found)
        result = pickle.loads(answer.read_bytes())  # noqa: S301 - this program's own
    if isinstance(result, Exception):
        raise result
    return result


def _answer(path: str, house_id: str, answer: str) -> None:
    """Read a model in the process of its own; write the house or the exception as a pickle."""
    try:
        result: House | Exception = _read(Path(path), house_id)
    except Exception as error:  # noqa: BLE001 - house_of_ifc raises it again
        error.add_note(traceback.format_exc())
        result = error
    Path(answer).write_bytes(pickle.dumps(result))


def _read(path: Path, house_id: str) -> House:
    source = Source(str(path), house_id)
    model = _Model(source, path)
    by_storey = {
        key: items for key, items in model.storeys().items() if _has(items, "IfcSpace", "IfcWall")
    }
    if not by_storey:
        raise source.fault("IfcSpace or IfcWall in the model", "none")
    # Storeys with walls only are left out: they may be foundations or attics.
    lived_in = [
        n for n, items in by_storey.items() if _has(items, "IfcSpace", "IfcDoor", "IfcWindow")
    ]
    for key in by_storey if lived_in else ():
        if key not in lived_in:
            source.warn(f"spaces, doors or windows on storey {key[0]}", "walls alone, left out")
    storeys = (model.storey(key[0], by_storey[key]) for key in lived_in or by_storey)
    return house_of_storeys(source, storeys)


def _parsed(source: Source, path: Path) -> Any:
    """Return the parsed file; a file of an older IFC2 schema is read as IFC2X3, with a warning."""
    import ifcopenshell

    try:
        return ifcopenshell.open(str(path))
    except ifcopenshell.SchemaError:
        text = path.read_text(encoding="latin-1")
        schema_match = _SCHEMA.search(text[:MAX_HEAD])
        if schema_match is None or not schema_match[2].upper().startswith("IFC2"):
            raise
        source.warn("schema IFC2X3 or IFC4", f"{schema_match[2][:40]}, read as IFC2X3")
        return ifcopenshell.file.from_string(_SCHEMA.sub(r"\1IFC2X3\3", text, count=1))


def _has(items: list[Any], *kinds: str) -> bool:
    """Return whether any of the products is of one of the kinds."""
    return any(item.is_a(kind) for item in items for kind in kinds)


class _Model:
    """A parsed model."""

    def __init__(self, source: Source, path: Path) -> None:
        self.source = source
        import ifcopenshell
        import ifcopenshell.geom
        import ifcopenshell.util.element

        if path.stat().st_size > MAX_BYTES:
            raise source.fault(f"at most {MAX_BYTES} bytes of IFC", path.stat().st_size)
        if b"END-ISO-10303-21" not in path.read_bytes()[-1000:]:
            raise source.fault("an IFC model that can be read", "one without its last lines")
        try:
            self.file = _parsed(source, path)
        except (RuntimeError, OSError, ValueError, ifcopenshell.Error) as error:
            raise source.fault("an IFC model that can be read", str(error) or "damage") from None
        for item in self.file.by_type("IfcDirection"):
            if not all(abs(ratio) <= MAX_RATIO for ratio in item.DirectionRatios):
                found = str(item.DirectionRatios)
                raise source.fault(f"directions of numbers within {MAX_RATIO:g}", found)
        self.triangles, self.origin = 0, np.zeros(3)
        self.geometry, self.element = ifcopenshell.geom, ifcopenshell.util.element
        self.settings = ifcopenshell.geom.settings()
        self.settings.set("use-world-coords", True)
        self.settings.set("disable-opening-subtractions", True)
        # A storey should have spaces as its parts; some programs say that it contains them.
        self.contained = {
            item.id(): relation.RelatingStructure
            for relation in self.file.by_type("IfcRelContainedInSpatialStructure")
            for item in relation.RelatedElements
        }

    def storeys(self) -> dict[tuple[str, float], list[Any]]:
        """Return {name and elevation of storey: its spaces, walls, doors, windows and stairs}."""
        from ifcopenshell.util.placement import get_storey_elevation

        by_storey: dict[tuple[str, float], list[Any]] = defaultdict(list)
        kinds = {
            "IfcSpace": MAX_ROOMS,
            "IfcWall": MAX_AXES,
            "IfcDoor": MAX_AXES,
            "IfcWindow": MAX_AXES,
            "IfcStair": MAX_AXES,
            "IfcStairFlight": MAX_AXES,
        }
        for kind, limit in kinds.items():
            products = self.file.by_type(kind)
            if len(products) > limit:
                raise self.source.fault(f"at most {limit} {kind}", len(products))
            for product in products:
                storey = self._storey(product)
                name = "no storey" if storey is None else f"{storey.Name or storey.GlobalId}"
                elevation = 0.0 if storey is None else float(get_storey_elevation(storey))
                by_storey[name, elevation].append(product)
        return dict(by_storey)

    def _storey(self, product: Any) -> Any:
        """Return the storey that holds a product directly or through up to 20 parents, or None."""
        parent = product
        for _ in range(20):
            parent = (
                self.element.get_aggregate(parent)
                or self.element.get_container(parent)
                or self.contained.get(parent.id())
            )
            if parent is None or parent.is_a("IfcBuildingStorey"):
                return parent
        return None

    def storey(self, name: str, products: list[Any]) -> DrawnStorey:
        """Return a storey with the drawing of its products."""
        bodies = [(product, body) for product in products if (body := self._body(product))]
        floors = [body.low for product, body in bodies if product.is_a("IfcSpace")]
        base = min(floors or [body.low for _, body in bodies], default=0.0)
        drawing = Drawing()
        for product, body in bodies:
            if product.is_a("IfcSpace"):
                label = str(product.LongName or product.Name or "")[:100]
                rings = (body.area.exterior, *body.area.interiors)
                outlines = tuple(
                    self.source.outline(list(ring.coords)[:-1], label[:40]) for ring in rings
                )
                drawing.rooms.append(DrawnRoom(label, outlines, body.high - body.low))
            elif product.is_a("IfcWall"):
                axis = axis_of_area(body.area, body.high - base)
                drawing.axes += [] if axis is None else [axis]
            elif product.is_a("IfcStair") or product.is_a("IfcStairFlight"):
                drawing.stairs += [] if (flight := _flight(body)) is None else [flight]
        drawing.height = max((axis.height for axis in drawing.axes), default=drawing.height)
        self._add_openings(drawing, products, base)
        return DrawnStorey(name[:100], base, drawing)

    def _add_openings(self, drawing: Drawing, products: list[Any], base: float) -> None:
        """Add the openings with a door or window, then the empty ones at other places."""
        nearest = NearestAxis(drawing.axes)
        for kind, product in sorted(self._holes(products), key=lambda pair: not pair[0]):
            body = self._body(product)
            if body is None:
                continue
            low = max(body.low - base, 0.0)
            opening_kind = kind or ("window" if low > SETTINGS.sill else "passage")
            name = f"opening_{len(drawing.openings)}"
            segment = nearest.segment(body.area, name, opening_kind)
            if segment is None:
                continue
            # Holes in two layers of a wall are one opening.
            if not drawing.shows(segment.start, segment.end):
                drawing.openings.append(
                    replace(segment, bottom=low, top=max(body.high - base, low))
                )

    def _holes(self, products: list[Any]) -> Iterator[tuple[str, Any]]:
        """Yield (kind, product) for each hole: kind is door, window or "", product is its body."""
        for product in products:
            if product.is_a("IfcWall"):
                for relation in product.HasOpenings:
                    hole = relation.RelatedOpeningElement
                    fillings = [r.RelatedBuildingElement for r in hole.HasFillings]
                    yield next((_leaf(item) for item in fillings if _leaf(item)), ""), hole
            elif _leaf(product) and not product.FillsVoids:
                yield _leaf(product), product

    def _body(self, product: Any) -> _Body | None:
        """Return the body of a product (the largest part of its area), or None without one."""
        if product.Representation is None:
            return None
        try:
            shape = self.geometry.create_shape(self.settings, product)
        except RuntimeError as error:
            self.source.warn(f"a body of {product.is_a()} {product.Name}", f"{error}, left out")
            return None
        points = np.array(shape.geometry.verts, dtype=np.float64).reshape(-1, 3)
        faces = np.array(shape.geometry.faces, dtype=np.int64).reshape(-1, 3)
        self.triangles += len(faces)
        if self.triangles > MAX_ALL_TRIANGLES:
            raise self.source.fault(f"at most {MAX_ALL_TRIANGLES} triangles", "more")
        if not 1 <= len(faces) <= MAX_TRIANGLES:
            what = f"{len(faces)} triangles, left out"
            self.source.warn(f"1 to {MAX_TRIANGLES} triangles of {product.is_a()}", what)
            return None
        if not self.origin.any() and np.abs(points).max() > MAX_COORDINATE:  # georeferenced
            self.origin = points.min(axis=0).round(-2)
        points -= self.origin
        if not np.isfinite(points).all() or np.abs(points).max() > MAX_COORDINATE:
            raise self.source.fault(f"coordinates within {MAX_COORDINATE:g} m", "others")
        plan = points[:, :2] * [1.0, -1.0]
        triangles = polygons(plan[faces])
        area = unary_union(triangles[areas_of(triangles) > 1e-9], grid_size=1e-5)
        parts = [part for part in getattr(area, "geoms", [area]) if isinstance(part, Polygon)]
        largest = max(parts, key=lambda part: part.area, default=None)
        if largest is None or largest.is_empty:
            return None
        heights = points[:, 2]
        plan_points = np.column_stack([plan, heights])
        return _Body(
            largest.simplify(1e-4), float(heights.min()), float(heights.max()), plan_points
        )


def _flight(body: _Body) -> Stairs | None:
    """Return stairs as a flight along their longer side, with its upper end where they are highest.

    None for stairs that are too short.
    """
    x0, z0, x1, z1 = body.area.bounds
    axis = 0 if x1 - x0 >= z1 - z0 else 1
    middle, width = ((z0 + z1) / 2, z1 - z0) if axis == 0 else ((x0 + x1) / 2, x1 - x0)
    low, high = ((x0, middle), (x1, middle)) if axis == 0 else ((middle, z0), (middle, z1))
    along, heights = body.points[:, axis], body.points[:, 2]
    top = along[heights > body.high - 0.2 * (body.high - body.low)].mean()
    foot = along[heights < body.low + 0.2 * (body.high - body.low)].mean()
    ends = (low, high) if top >= foot else (high, low)
    flight = Stairs("", "", *ends, width)
    return flight if flight.length >= STAIRS.least_flight and width > 0 else None


def _leaf(product: Any) -> str:
    """Return "door" or "window" for such a product; empty for any other product."""
    kinds = {"IfcDoor": "door", "IfcWindow": "window"}
    return next((kind for name, kind in kinds.items() if product.is_a(name)), "")


PLAN_FORMAT = PlanFormat(
    "IFC",
    lambda plan: is_ifc(plan.head),
    lambda plan: house_of_ifc(plan.path, plan.house_id),
    suffixes=(".ifc",),
    needs="plan2scene[formats]",
)

if __name__ == "__main__":
    _answer(*sys.argv[1:])
