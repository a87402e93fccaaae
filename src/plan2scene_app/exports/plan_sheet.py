"""The dimensioned plan as a drawing: ``plan.pdf`` with a page for each level, and ``plan.svg``.

Each sheet is A4 at a round scale. It shows walls, doors with their swing and width, windows,
stairs, the names, net areas and inner sizes of rooms, the outer dimensions and a scale bar.
``plan.svg`` is the lowest level; a higher level's SVG is ``plan_{level}.svg``.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING
from warnings import catch_warnings, simplefilter

import numpy as np
from shapely import get_coordinates
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry
from shapely.ops import polylabel, unary_union

from plan2scene.errors import InputError
from plan2scene.house import House, Room, SurfaceKey
from plan2scene.io import atomic_path
from plan2scene.mesh.assembly import Storey, assemble
from plan2scene.mesh.texture_files import TileTexture
from plan2scene.plans.geometry import room_polygon
from plan2scene.plans.levels import flight_area
from plan2scene_app.drawing import legible

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MM = 1 / 25.4  # inches


@dataclass(frozen=True)
class SheetSettings:
    """How sheets are drawn."""

    page_mm: tuple[float, float] = (297.0, 210.0)  #: A4, the longer side first
    margin_mm: float = 26.0  #: around the plan, for dimensions, title and scale bar
    scales: tuple[int, ...] = (50, 75, 100, 150, 200, 250, 300, 400, 500, 750, 1000)
    dimension_mm: float = 9.0  #: from the house to its farther dimension line, on the page
    font_pt: float = 7.0
    line_mm: float = 3.0  #: height of a line of a label, and usual width of a letter, on the page
    letter_mm: float = 1.4
    same_m: float = 0.15  #: corners closer than this along an axis are one dimension point
    full: float = 0.97  #: a room that fills more than this share of its box is a rectangle
    dark: str = "#35322e"
    light: str = "#8a857c"


SETTINGS = SheetSettings()
#: Keep text in the SVG as text, and make its ids the same in each run.
_STYLE = {"svg.hashsalt": "plan2scene", "svg.fonttype": "none", "font.size": SETTINGS.font_pt}


def write_plan(house: House, textures: dict[SurfaceKey, TileTexture], folder: Path) -> None:
    """Write the sheets of a house's storeys; the textures are not needed."""
    import matplotlib as mpl
    from matplotlib.backends.backend_pdf import PdfPages

    del textures
    storeys = assemble(house).storeys
    id_by_name = {room.name: room.id.replace("_", " ") for room in house.rooms}
    title = legible(house.title, house.id)
    # No dates and fixed ids: the same house gives the same bytes.
    with mpl.rc_context(_STYLE):
        sheets = [_sheet(storey, house.title) for storey in storeys]
        for number, (storey, sheet) in enumerate(zip(storeys, sheets, strict=True)):
            name = f"plan_{storey.level.id}.svg" if number else "plan.svg"
            with atomic_path(folder / name) as temporary, catch_warnings():
                simplefilter("ignore")  # letters that this machine's font lacks
                sheet.savefig(temporary, format="svg", metadata={"Date": None})
        # An SVG is shown with its reader's fonts; a PDF lacks letters that its own font lacks.
        for text in (text for sheet in sheets for text in sheet.axes[0].texts):
            name, _, rest = text.get_text().replace(house.title, title).partition("\n")
            text.set_text(f"{legible(name, id_by_name.get(name, name))}\n{rest}".strip())
        with (
            atomic_path(folder / "plan.pdf") as temporary,
            PdfPages(temporary, metadata={"CreationDate": None}) as pages,
        ):
            for sheet in sheets:
                pages.savefig(sheet)


def _sheet(storey: Storey, title: str) -> Figure:
    """Return the drawing of a storey; x runs right, z down the page, at a round scale."""
    from matplotlib.figure import Figure

    solid = unary_union([body.cap for body in storey.bodies])
    rooms = [room_polygon(room) for room in storey.house.rooms]
    outline = unary_union([solid, *rooms])
    x0, z0, x1, z1 = outline.bounds
    page = SETTINGS.page_mm if x1 - x0 >= z1 - z0 else SETTINGS.page_mm[::-1]
    free = [side - 2 * SETTINGS.margin_mm for side in page]
    fits = [
        s
        for s in SETTINGS.scales
        if 1000 * (x1 - x0) <= s * free[0] and 1000 * (z1 - z0) <= s * free[1]
    ]
    if not fits:
        raise InputError(f"a house that A4 holds at 1:{SETTINGS.scales[-1]}", "a larger one")
    scale = fits[0]
    figure = Figure(figsize=(page[0] * _MM, page[1] * _MM))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set_axis_off()
    half = [side * scale / 2000 for side in page]
    middle = (x0 + x1) / 2, (z0 + z1) / 2
    axes.set_xlim(middle[0] - half[0], middle[0] + half[0])
    axes.set_ylim(middle[1] + half[1], middle[1] - half[1])
    for room, polygon in zip(storey.house.rooms, rooms, strict=True):
        if room.open_air:
            _fill(axes, polygon, "white", SETTINGS.light)
    _draw_walls(axes, storey, solid)
    for flight, steps in storey.flights:
        _fill(axes, flight_area(flight), "white", SETTINGS.light)
        ends = np.array([flight.start, flight.end])
        axes.plot(*ends.T, color=SETTINGS.light, linewidth=0.6)
        x, y = ends.mean(axis=0)
        axes.text(x, y, f"{steps} steps", ha="center", color=SETTINGS.light)
    metres = scale / 1000  # metres of the house per millimetre of the page
    for room, polygon in zip(storey.house.rooms, rooms, strict=True):
        _label(axes, room, polygon, metres)
    _dimensions(axes, outline, SETTINGS.dimension_mm * metres)
    inside = [
        p.area for room, p in zip(storey.house.rooms, rooms, strict=True) if not room.open_air
    ]
    _title(axes, storey, title, scale, sum(inside))
    return figure


def _fill(axes: Axes, area: BaseGeometry, face: str, edge: str, width: float = 0.6) -> None:
    """Draw a polygon or several, with their holes."""
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path as Outline

    for part in getattr(area, "geoms", [area]):
        if isinstance(part, Polygon) and not part.is_empty:
            rings = [np.asarray(ring.coords) for ring in (part.exterior, *part.interiors)]
            path = Outline.make_compound_path(*(Outline(ring, closed=True) for ring in rings))
            axes.add_patch(PathPatch(path, facecolor=face, edgecolor=edge, linewidth=width))


def _draw_walls(axes: Axes, storey: Storey, solid: BaseGeometry) -> None:
    """Draw the walls with their openings; a door leaf swings into the portal's own room."""
    windows, leaves = [], []
    for portal in storey.portals:
        margin = portal.side.wall.depth / 2
        left, right = portal.hole.left, portal.hole.right
        frame, reach = portal.side.frame, portal.depth + margin
        ends = np.array([left, right])
        hole = Polygon([*frame.plan(ends, margin), *frame.plan(ends[::-1], -reach)])
        pane = hole.intersection(solid)
        solid = solid.difference(hole)
        kind = portal.hole.opening.kind
        if kind == "window":
            windows.append(pane)
        elif kind == "door":
            leaves.append((frame, left, right))
    _fill(axes, solid, SETTINGS.dark, SETTINGS.dark)
    for pane in windows:
        _fill(axes, pane, "#dfeaee", SETTINGS.dark)
    turn = np.linspace(0, np.pi / 2, 16)
    for frame, left, right in leaves:
        width = right - left
        arc = [frame.plan(np.array([left + width * np.cos(t)]), width * np.sin(t))[0] for t in turn]
        hinge = frame.plan(np.array([left]), 0.0)[0]
        axes.plot(*np.array([hinge, arc[-1]]).T, color=SETTINGS.dark, linewidth=0.9)
        axes.plot(*np.array(arc).T, color=SETTINGS.light, linewidth=0.5)
        place = frame.plan(np.array([(left + right) / 2]), 0.0)[0]
        size = 0.75 * SETTINGS.font_pt
        text = f"{100 * width:.0f}"
        x, y = place
        axes.text(x, y, text, ha="center", va="center", fontsize=size, color=SETTINGS.light)


def _label(axes: Axes, room: Room, polygon: Polygon, metres: float) -> None:
    """Write a room's name, its net area and, if it is a rectangle with space, its inner sides.

    The label of a narrow room is turned. `metres` are those of a millimetre of the page.
    """
    x0, z0, x1, z1 = polygon.bounds
    lines = [room.name or room.id.replace("_", " "), f"{polygon.area:.2f} m\u00b2"]
    full = polygon.area > SETTINGS.full * (x1 - x0) * (z1 - z0)
    if full:
        lines.append(f"{x1 - x0:.2f} x {z1 - z0:.2f} m")
    place = polygon.centroid if full else polylabel(polygon, 0.05)
    turned = max(map(len, lines)) * SETTINGS.letter_mm * metres > x1 - x0 < z1 - z0
    space = (x1 - x0 if turned else z1 - z0) / (SETTINGS.line_mm * metres)
    text = "\n".join(lines[: max(2, int(space))])
    angle = 90.0 if turned else 0.0
    axes.text(
        *(place.x, place.y, text), ha="center", va="center", rotation=angle, color=SETTINGS.dark
    )


def _dimensions(axes: Axes, outline: BaseGeometry, away: float) -> None:
    """Draw the outer dimensions above and left of a house: between corners, and the whole side."""
    x0, z0, x1, z1 = outline.bounds
    corners = get_coordinates(outline)
    for axis, (low, high) in enumerate(((x0, x1), (z0, z1))):
        steps = [low]
        for value in sorted(corners[:, axis]):
            if value - steps[-1] > SETTINGS.same_m:
                steps.append(float(value))
        steps[-1] = high
        start = z0 if axis == 0 else x0
        if len(steps) > 2:
            _chain(axes, steps, start - away / 2, axis)
        _chain(axes, [low, high], start - away, axis)


def _chain(axes: Axes, steps: list[float], across: float, axis: int) -> None:
    """Draw a dimension line along an axis, with a tick and the distances between `steps`."""
    line = np.array([[step, across] for step in steps])[:, :: 1 if axis == 0 else -1]
    axes.plot(*line.T, color=SETTINGS.dark, linewidth=0.5, marker=(2, 0, -45), markersize=5)
    for a, b in pairwise(line):
        text = f"{np.linalg.norm(b - a):.2f}"
        x, y = (a + b) / 2
        if axis:
            axes.text(x, y, text, color=SETTINGS.dark, rotation=90.0, ha="right", va="center")
        else:
            axes.text(x, y, text, color=SETTINGS.dark, ha="center", va="bottom")


def _title(axes: Axes, storey: Storey, title: str, scale: int, area: float) -> None:
    """Write the title line and draw the scale bar at the foot of the page."""
    from matplotlib.patches import Rectangle

    (left, right), (bottom, _) = axes.get_xlim(), axes.get_ylim()
    margin = SETTINGS.margin_mm * scale / 2000
    level = f", {storey.level.name}" if storey.level.name else ""
    size = f"{area:.2f} m\u00b2 net indoors, 1:{scale} on A4"
    text = f"{title}{level}: {size}, metres; doors in centimetres"
    foot = bottom - margin
    axes.text(left + margin, foot, text, va="center", color=SETTINGS.dark)
    step = 1.0 if scale <= 200 else 5.0
    for k in range(5):
        place = (right - margin - (5 - k) * step, foot - 0.002 * scale)
        face = SETTINGS.dark if k % 2 == 0 else "white"
        bar = Rectangle(place, step, 0.0015 * scale, facecolor=face, edgecolor=SETTINGS.dark)
        bar.set_linewidth(0.5)
        axes.add_patch(bar)
    for k in (0, 1, 5):
        place = (right - margin - (5 - k) * step, foot - 0.0025 * scale)
        axes.text(*place, f"{k * step:g} m"[: None if k else 1], ha="center", va="bottom")
