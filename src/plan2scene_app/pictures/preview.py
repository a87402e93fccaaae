"""preview.png: a plan view of each storey, cut below the ceiling, and an oblique view."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import cv2
import numpy as np
from PIL import Image, ImageDraw
from shapely.geometry import Polygon
from shapely.ops import polylabel, unary_union

from plan2scene.camera import Camera, focal_of
from plan2scene.colour import linear_to_srgb, srgb_to_linear
from plan2scene.house import House, Stairs, SurfaceKey
from plan2scene.mesh.assembly import Assembly, Storey, assemble
from plan2scene.mesh.parts import Colour, MeshPart, PartBuilder
from plan2scene.mesh.texture_files import TileTexture
from plan2scene.plans.geometry import room_polygon
from plan2scene.plans.levels import flight_area
from plan2scene_app.drawing import legible, wide_font
from plan2scene_app.pictures.renderer import Triangles, look_at

BACKGROUND: Colour = (247, 246, 243)
WINDOW_COLOUR: Colour = (176, 205, 216)


@dataclass(frozen=True)
class PreviewSettings:
    """How houses are drawn from above. Light is a factor on a surface's colour."""

    cut_m: float = 1.7  #: height at which the plan view cuts the storey
    side: int = 800  #: height and width of each view, pixels
    finer: int = 2  #: views are drawn this many times larger and averaged down
    sky: float = 0.82  #: light on surfaces that face up
    ground: float = 0.55  #: light on surfaces that face down
    sun: float = 0.30  #: additional light on surfaces that face the sun
    to_sun: tuple[float, float, float] = (-0.45, 0.78, 0.43)
    corner_reach_m: float = 0.22  #: distance from a corner at which its darkening falls to 1/e
    corner_dark: float = 0.42  #: share of the light that is lost in a corner


SETTINGS = PreviewSettings()


@dataclass(frozen=True)
class _View:
    """Direction from which a perspective view is seen, and its field of view, degrees."""

    elevation_deg: float
    azimuth_deg: float
    fov_deg: float


_OBLIQUE = _View(61.0, 24.0, 28.0)  # from the upper south-east
_FROM_ABOVE = _View(90.0, 0.0, 50.0)


def render_preview(
    house: House,
    textures: Mapping[SurfaceKey, TileTexture],
    assembly: Assembly | None = None,
    side: int = SETTINGS.side,
) -> np.ndarray:
    """Return (n side, 2 side, 3) uint8 sRGB: plan view with room names, and oblique view.

    There is a row for each of the n levels, the lowest first.
    """
    rows = []
    for storey in (assembly or assemble(house)).storeys:
        plan = _plan_view(storey, textures, side)
        oblique = _view(storey, textures, side, _OBLIQUE)
        rows.append(np.concatenate([plan, oblique], axis=1))
    return np.concatenate(rows)


def render_plan(house: House, captions: Mapping[str, str], side: int = SETTINGS.side) -> np.ndarray:
    """Return the plan view in plain colours, (n side, side, 3) uint8 sRGB: n levels, lowest first.

    `captions` are texts by room id; in a room's label they replace its area.
    """
    storeys = assemble(house).storeys
    return np.concatenate([_plan_view(storey, {}, side, captions) for storey in storeys])


def render_from_above(
    house: House, textures: Mapping[SurfaceKey, TileTexture], side: int = SETTINGS.side
) -> np.ndarray:
    """Return perspective views from straight above without ceilings, (n side, side, 3) uint8.

    There is one for each of the n levels, the lowest first.
    """
    storeys = assemble(house).storeys
    return np.concatenate([_view(storey, textures, side, _FROM_ABOVE) for storey in storeys])


def _extent(house: House) -> tuple[np.ndarray, np.ndarray]:
    """Return the least and greatest (x, z) of a house with its walls, metres."""
    points = np.array([p for room in house.rooms for ring in room.rings for p in ring])
    depth = max((wall.depth for wall in house.walls), default=0.1)
    return points.min(axis=0) - depth, points.max(axis=0) + depth


def _plan_view(
    storey: Storey,
    textures: Mapping[SurfaceKey, TileTexture],
    side: int,
    captions: Mapping[str, str] | None = None,
) -> np.ndarray:
    """Return the orthographic view from above of everything below `SETTINGS.cut_m`."""
    house = storey.house
    low, high = _extent(house)
    centre = (low + high) / 2
    size = (side * SETTINGS.finer, side * SETTINGS.finer)
    scale = 0.86 * min(size[1] / (high[0] - low[0]), size[0] / (high[1] - low[1]))
    target = np.array([centre[0], 0.0, centre[1]])
    camera = look_at(target + [0, 50.0, 0], target, scale, size, orthographic=True)
    left_out = ("/ceiling", "/handrail/")
    parts = [p for p in storey.parts if not any(word in p.name for word in left_out)]
    parts += _section(storey)
    small = _draw(parts, textures, camera, house, top=SETTINGS.cut_m + 2e-3)
    scale = camera.focal_px / SETTINGS.finer

    def project(point: tuple[float, float]) -> tuple[float, float]:
        x, y = camera.project(np.array([point[0], 0.0, point[1]])) / SETTINGS.finer
        return float(x), float(y)

    small = draw_flights(small, storey.flights, project)
    return annotate(small, house, captions or {}, project, scale, storey.level.name)


def _section(storey: Storey) -> list[MeshPart]:
    """Return flat parts at the cut height: the sections of walls and of the windows in them."""
    solid = unary_union([b.cap for b in storey.bodies if b.side.wall.height > SETTINGS.cut_m])
    parts, windows = [], []
    for portal in storey.portals:
        if portal.hole.top <= SETTINGS.cut_m and portal.hole.opening.kind != "window":
            continue
        margin = portal.side.wall.depth / 2
        ends = np.array([portal.hole.left, portal.hole.right])
        frame = portal.side.frame
        reach = portal.depth + margin
        hole = Polygon([*frame.plan(ends, margin), *frame.plan(ends[::-1], -reach)])
        if portal.hole.opening.kind == "window":
            windows.append(hole.intersection(solid))
        solid = solid.difference(hole)
    for name, area, colour in (
        ("section/walls", solid, SECTION_COLOUR),
        ("section/windows", unary_union(windows), WINDOW_COLOUR),
    ):
        builder = PartBuilder()
        builder.level(area, SETTINGS.cut_m, colour=colour)
        if builder:
            parts.append(builder.build(name))
    return parts


def _view(
    storey: Storey,
    textures: Mapping[SurfaceKey, TileTexture],
    side: int,
    view: _View,
) -> np.ndarray:
    """Return a perspective view of a storey without ceilings; the storey fills the picture."""
    house = storey.house
    low, high = _extent(house)
    height = max((wall.height for wall in house.walls), default=2.5)
    corners = np.array(
        [[x, y, z] for x in (low[0], high[0]) for y in (0, height) for z in (low[1], high[1])]
    )
    target = corners.mean(axis=0)
    size = (side * SETTINGS.finer, side * SETTINGS.finer)
    elevation, azimuth = math.radians(view.elevation_deg), math.radians(view.azimuth_deg)
    flat = math.cos(elevation)
    direction = np.array([math.sin(azimuth) * flat, math.sin(elevation), math.cos(azimuth) * flat])
    focal = focal_of(math.radians(view.fov_deg), size[1])
    distance = 2.2 * float(np.linalg.norm(high - low)) + height
    for _ in range(3):  # the distance at which the house fills the view, by proportion
        camera = look_at(target + distance * direction, target, focal, size)
        points = camera.project(corners)
        middle = np.array([(size[1] - 1) / 2, (size[0] - 1) / 2])
        spread = (np.abs(points - middle) / middle).max()
        distance *= spread / 0.9
    camera = look_at(target + distance * direction, target, focal, size)
    parts = [p for p in storey.parts if not p.name.endswith("/ceiling")]
    return _draw(parts, textures, camera, house)


def _draw(
    parts: Iterable[MeshPart],
    textures: Mapping[SurfaceKey, TileTexture],
    camera: Camera,
    house: House,
    top: float = math.inf,
) -> np.ndarray:
    """Return the picture (h, w, 3) uint8 sRGB of parts, averaged down.

    Only triangles whose lowest corner is not above `top` (metres) are drawn.
    """
    triangles = Triangles.of(parts, textures)
    below = triangles.corners[..., 1].min(axis=1) <= top
    image = np.empty((camera.height * camera.width, 3), dtype=np.float32)
    image[:] = srgb_to_linear(np.array(BACKGROUND, np.uint8))
    depth = np.full(len(image), np.inf, dtype=np.float32)
    opaque = triangles.visible(camera, below & ~triangles.glass)
    light = _light(triangles.normals, opaque.triangles, opaque.points, house)
    image[opaque.pixels] = triangles.looks(camera, opaque) * light[:, None]
    depth[opaque.pixels] = opaque.depth
    panes = triangles.visible(camera, below & triangles.glass)
    front = panes.depth < depth[panes.pixels]
    seen, t = panes.pixels[front], panes.triangles[front]
    image[seen] = 0.7 * image[seen] + 0.3 * triangles.colours[t]
    return _small(image.reshape(camera.height, camera.width, 3))


def _light(normals: np.ndarray, t: np.ndarray, points: np.ndarray, house: House) -> np.ndarray:
    """Return the (p,) light of sky, ground and sun on points of triangles `t`; corners darken."""
    up = 0.5 + 0.5 * normals[:, 1]
    to_sun = np.array(SETTINGS.to_sun) / np.linalg.norm(SETTINGS.to_sun)
    light = (
        SETTINGS.ground
        + (SETTINGS.sky - SETTINGS.ground) * up
        + SETTINGS.sun * np.maximum(normals @ to_sun, 0.0)
    )
    light = light.astype(np.float32)[t]
    flat = (normals[:, 1] > 0.9)[t]
    low = np.flatnonzero(~flat | (points[:, 1] < 0.01))
    to_corner = np.maximum(points[low, 1], 0.0)
    floor = np.flatnonzero(flat[low])
    to_corner[floor] = _wall_distance(house, points[low[floor]])
    light[low] *= 1.0 - SETTINGS.corner_dark * np.exp(-to_corner / SETTINGS.corner_reach_m)
    return light


def _wall_distance(house: House, points: np.ndarray, cell: float = 0.02) -> np.ndarray:
    """Return each point's plan distance in metres to the nearest wall, on a grid of `cell`."""
    low, high = _extent(house)
    shape = np.ceil((high - low) / cell).astype(int) + 2
    grid = np.full((shape[1], shape[0]), 255, dtype=np.uint8)
    for wall in house.walls:
        ends = [np.round((np.array(p) - low) / cell).astype(int) for p in (wall.start, wall.end)]
        cv2.line(grid, tuple(ends[0].tolist()), tuple(ends[1].tolist()), 0, 1)
    distance = cv2.distanceTransform(grid, cv2.DIST_L2, 5) * cell
    column, row = (
        np.clip(np.rint((points[:, axis] - low[k]) / cell).astype(np.int32), 0, shape[k] - 1)
        for k, axis in enumerate((0, 2))
    )
    return np.asarray(distance.ravel()[row * distance.shape[1] + column])


def _small(image: np.ndarray) -> np.ndarray:
    """Return a supersampled linear picture averaged down, as uint8 sRGB."""
    share = 1 / SETTINGS.finer
    mean = cv2.resize(image, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)
    return np.asarray(np.round(linear_to_srgb(mean.clip(0, 1)) * 255).astype(np.uint8))


SECTION_COLOUR: Colour = (52, 50, 48)
STEP_COLOUR: Colour = (96, 88, 80)


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
        Second line of a room's label, by room id; if `captions` is empty, the areas are written.
    project : callable
        Pixel (x, y) of a point (x, z) in metres.
    scale : float
        Pixels per metre.
    title : str
        Text in the upper left corner.
    """
    picture = Image.fromarray(image)
    draw = ImageDraw.Draw(picture)
    plates: list[tuple[float, ...]] = []
    for room in sorted(house.rooms, key=lambda room: -room_polygon(room).area):
        polygon = room_polygon(room)
        centre = project(_label_point(polygon))
        types = legible(room.title, " / ".join(room.types))
        second = captions.get(room.id, "") if captions else f"{polygon.area:.1f} m²"
        full = f"{types}\n{second}".strip()
        # A small room gets a small label, or none if it would overlap a larger room's label.
        short, kinds = (full if captions else types, 11), " / ".join(room.types)
        for text, size in ((full, 15), short, (types, 11), (kinds, 11)):
            if _label(draw, text, centre, size, plates, polygon, scale):
                break
    x0, y0 = 24, picture.height - 26
    draw.rectangle([x0, y0, x0 + scale, y0 + 5], fill=SECTION_COLOUR)
    draw.text((x0 + scale + 8, y0 + 2), "1 m", fill=SECTION_COLOUR, font=wide_font(14), anchor="lm")
    draw.text((24, 24), title, fill=SECTION_COLOUR, font=wide_font(18))
    return np.asarray(picture)


def draw_flights(
    image: np.ndarray,
    flights: Iterable[tuple[Stairs, int]],
    project: Callable[[tuple[float, float]], tuple[float, float]],
) -> np.ndarray:
    """Return a plan view (h, w, 3) uint8 with stairs drawn as steps and an arrow that points up.

    `flights` are pairs of stairs and their number of steps; `project` is as in :func:`annotate`.
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
    """Return a point well inside a room: its centroid, or else its pole of inaccessibility."""
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
    """Write text on a light plate if the plate fits; return whether it was written."""
    font = wide_font(size)
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
