"""Names of rooms and a scale bar over a plan view."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont
from shapely.geometry import Polygon
from shapely.ops import polylabel

from plan2scene.house import House, Room, Stairs
from plan2scene.mesh.parts import Colour
from plan2scene.plans.geometry import room_polygon
from plan2scene.plans.levels import flight_area

SECTION_COLOUR: Colour = (52, 50, 48)
STEP_COLOUR: Colour = (96, 88, 80)


def room_title(room: Room) -> str:
    """Return a room's name for people: its types."""
    return " / ".join(room.types)


def annotate(
    image: np.ndarray,
    house: House,
    captions: Mapping[str, str],
    project: Callable[[tuple[float, float]], tuple[float, float]],
    scale: float,
    title: str = "",
) -> np.ndarray:
    """Return a plan view (h, w, 3) uint8 with room names, captions or areas, and a scale bar.

    Parameters
    ----------
    captions : mapping
        Second line of a room's label by its id, in place of the areas; empty for areas.
    project : callable
        Pixel (x, y) of a point (x, z) in metres.
    scale : float
        Pixels per metre.
    title : str
        In the upper left corner.
    """
    picture = Image.fromarray(image)
    draw = ImageDraw.Draw(picture)
    taken: list[tuple[float, ...]] = []
    for room in sorted(house.rooms, key=lambda room: -room_polygon(room).area):
        whole = room_polygon(room)
        centre = project(_label_point(whole))
        types = room_title(room)
        second = captions.get(room.id, "") if captions else f"{whole.area:.1f} m²"
        full = f"{types}\n{second}".strip()
        # A small room gets a small label, and none where a larger room's label is.
        for text, size in ((full, 15), (full if captions else types, 11), (types, 11)):
            if _label(draw, text, centre, size, taken, whole, scale):
                break
    x0, y0 = 24, picture.height - 26
    draw.rectangle([x0, y0, x0 + scale, y0 + 5], fill=SECTION_COLOUR)
    draw.text((x0 + scale + 8, y0 + 2), "1 m", fill=SECTION_COLOUR, font=_font(14), anchor="lm")
    draw.text((24, 24), title, fill=SECTION_COLOUR, font=_font(18))
    return np.asarray(picture)


def draw_flights(
    image: np.ndarray,
    flights: Iterable[tuple[Stairs, int]],
    project: Callable[[tuple[float, float]], tuple[float, float]],
) -> np.ndarray:
    """Return a plan view (h, w, 3) uint8 with stairs as plans draw them: steps, an arrow upwards.

    `flights` come with their number of steps, `project` is as of :func:`annotate`.
    """
    picture = Image.fromarray(image)
    draw = ImageDraw.Draw(picture)
    for stairs, count in flights:
        a, b, c, d = (np.array(p) for p in flight_area(stairs).exterior.coords[:4])
        for k in range(count + 1):
            share = k / count
            ends = (a + share * (b - a), d + share * (c - d))
            draw.line([project((p[0], p[1])) for p in ends], STEP_COLOUR, 1)
        for near, far in ((a, b), (d, c)):
            draw.line([project((p[0], p[1])) for p in (near, far)], STEP_COLOUR, 1)
        foot, head = np.array(project(stairs.start)), np.array(project(stairs.end))
        back = 9 * (foot - head) / max(float(np.linalg.norm(foot - head)), 1e-9)
        side = np.array([-back[1], back[0]]) * 0.5
        draw.line([tuple(foot), tuple(head)], SECTION_COLOUR, 2)
        draw.line(
            [tuple(head + back + side), tuple(head), tuple(head + back - side)], SECTION_COLOUR, 2
        )
    return np.asarray(picture)


def _label_point(polygon: Polygon) -> tuple[float, float]:
    """Return a point well inside a room: its centroid when that is inside, else the pole."""
    centre = polygon.centroid
    point = centre if polygon.buffer(-0.3).contains(centre) else polylabel(polygon, 0.05)
    return float(point.x), float(point.y)


def _label(
    draw: ImageDraw.ImageDraw,
    text: str,
    centre: tuple[float, float],
    size: int,
    taken: list[tuple[float, ...]],
    room: Polygon,
    scale: float,
) -> bool:
    """Write text on a light plate if there is room for it; return whether it was written."""
    font = _font(size)
    box = draw.multiline_textbbox(centre, text, font=font, anchor="mm", align="center")
    plate = (box[0] - 6, box[1] - 5, box[2] + 6, box[3] + 5)
    width, height = (plate[2] - plate[0]) / scale, (plate[3] - plate[1]) / scale
    if width * height > 1.2 * room.area or any(_overlap(plate, other) for other in taken):
        return False
    taken.append(plate)
    draw.rounded_rectangle(plate, radius=6, fill=(250, 249, 246))
    draw.multiline_text(centre, text, font=font, anchor="mm", align="center", fill=(40, 38, 36))
    return True


def _overlap(a: tuple[float, ...], b: tuple[float, ...]) -> bool:
    """Return whether two boxes (left, top, right, bottom) overlap."""
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Return the font that matplotlib ships (Pillow's own lacks a superscript 2)."""
    package = find_spec("matplotlib")
    if package is None or not package.submodule_search_locations:
        return ImageFont.load_default(size)
    folder = Path(package.submodule_search_locations[0]) / "mpl-data" / "fonts" / "ttf"
    return ImageFont.truetype(folder / "DejaVuSans.ttf", size)
