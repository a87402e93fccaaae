"""preview.png: the house from above, cut open at door height, and obliquely without ceilings."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import cv2
import numpy as np
from shapely.geometry import Polygon
from shapely.ops import unary_union

from plan2scene.camera import Camera, focal_of
from plan2scene.colour import linear_to_srgb, srgb_to_linear
from plan2scene.house import House, SurfaceKey
from plan2scene.mesh.house_mesh import Assembly, assemble
from plan2scene.mesh.labels import SECTION_COLOUR, annotate, draw_flights
from plan2scene.mesh.parts import Colour, MeshPart, PartBuilder
from plan2scene.mesh.renderer import Triangles
from plan2scene.mesh.storey import Storey
from plan2scene.mesh.textures import TileTexture

BACKGROUND: Colour = (247, 246, 243)
WINDOW_COLOUR: Colour = (176, 205, 216)
#: Height in metres at which the plan view cuts the house open.
CUT = 1.7
#: Height and width in pixels of each of the two views.
SIDE = 800
#: The views are drawn so many times larger and averaged down.
SUPERSAMPLING = 2
#: Direction to the sun, and shares of sky, ground and sun in the light.
_SUN = np.array([-0.45, 0.78, 0.43]) / np.linalg.norm([-0.45, 0.78, 0.43])
_SKY, _GROUND, _SUNLIGHT = 0.82, 0.55, 0.30
#: How far corners darken, metres, and how much.
_CORNER_REACH, _CORNER_DARK = 0.22, 0.42


@dataclass(frozen=True)
class _View:
    """Where a perspective view is from, and its field of view, degrees."""

    elevation_deg: float
    azimuth_deg: float
    fov_deg: float


_OBLIQUE = _View(61.0, 24.0, 28.0)  # from the upper south-east
_FROM_ABOVE = _View(90.0, 0.0, 50.0)


def render_preview(
    house: House,
    textures: Mapping[SurfaceKey, TileTexture],
    assembly: Assembly | None = None,
    side: int = SIDE,
) -> np.ndarray:
    """Return (n side, 2 side, 3) uint8 sRGB: plan view with room names, and oblique view.

    A row for each of the n levels, the lowest first.
    """
    rows = []
    for storey in (assembly or assemble(house)).storeys:
        plan = _plan_view(storey, textures, side)
        oblique = _view(storey, textures, side, _OBLIQUE)
        rows.append(np.concatenate([plan, oblique], axis=1))
    return np.concatenate(rows)


def render_plan(house: House, captions: Mapping[str, str], side: int = SIDE) -> np.ndarray:
    """Return the plan view in plain colours, (n side, side, 3) uint8 sRGB: n levels, lowest first.

    `captions` holds a line for a room's label in place of its area, by room id.
    """
    storeys = assemble(house).storeys
    return np.concatenate([_plan_view(storey, {}, side, captions) for storey in storeys])


def render_from_above(
    house: House, textures: Mapping[SurfaceKey, TileTexture], side: int = SIDE
) -> np.ndarray:
    """Return the perspective views from straight above without ceilings, (n side, side, 3) uint8.

    One for each of the n levels, the lowest first.
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
    """Return the orthographic view from above of what is below `CUT`."""
    house = storey.house
    low, high = _extent(house)
    centre = (low + high) / 2
    size = (side * SUPERSAMPLING, side * SUPERSAMPLING)
    scale = 0.86 * min(size[1] / (high[0] - low[0]), size[0] / (high[1] - low[1]))
    target = np.array([centre[0], 0.0, centre[1]])
    camera = Camera.look_at(target + [0, 50.0, 0], target, scale, size, orthographic=True)
    left_out = ("/ceiling", "/handrail/")
    parts = [p for p in storey.parts if not any(word in p.name for word in left_out)]
    parts += _section(storey)
    small = _draw(parts, textures, camera, house, top=CUT + 2e-3)
    scale = camera.focal_px / SUPERSAMPLING

    def project(point: tuple[float, float]) -> tuple[float, float]:
        x, y = camera.project(np.array([point[0], 0.0, point[1]])) / SUPERSAMPLING
        return float(x), float(y)

    small = draw_flights(small, storey.flights, project)
    return annotate(small, house, captions or {}, project, scale, storey.level.name)


def _section(storey: Storey) -> list[MeshPart]:
    """Return flat parts at `CUT`: the wall bodies that it meets, and the windows in them."""
    solid = unary_union([b.cap for b in storey.bodies if b.side.wall.height > CUT])
    parts, windows = [], []
    for portal in storey.portals:
        if portal.hole.top <= CUT and portal.hole.opening.kind != "window":
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
        builder.level(area, CUT, colour=colour)
        if builder:
            parts.append(builder.build(name))
    return parts


def _view(
    storey: Storey,
    textures: Mapping[SurfaceKey, TileTexture],
    side: int,
    view: _View,
) -> np.ndarray:
    """Return a perspective view without ceilings that the storey fills."""
    house = storey.house
    low, high = _extent(house)
    height = max((wall.height for wall in house.walls), default=2.5)
    corners = np.array(
        [[x, y, z] for x in (low[0], high[0]) for y in (0, height) for z in (low[1], high[1])]
    )
    target = corners.mean(axis=0)
    size = (side * SUPERSAMPLING, side * SUPERSAMPLING)
    elevation, azimuth = math.radians(view.elevation_deg), math.radians(view.azimuth_deg)
    flat = math.cos(elevation)
    direction = np.array([math.sin(azimuth) * flat, math.sin(elevation), math.cos(azimuth) * flat])
    focal = focal_of(math.radians(view.fov_deg), size[1])
    distance = 2.2 * float(np.linalg.norm(high - low)) + height
    for _ in range(3):  # the distance at which the house fills the view, by proportion
        camera = Camera.look_at(target + distance * direction, target, focal, size)
        points = camera.project(corners)
        middle = np.array([(size[1] - 1) / 2, (size[0] - 1) / 2])
        spread = (np.abs(points - middle) / middle).max()
        distance *= spread / 0.9
    camera = Camera.look_at(target + distance * direction, target, focal, size)
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

    Of triangles that begin below `top`, metres.
    """
    triangles = Triangles.of(parts, textures)
    below = triangles.corners[..., 1].min(axis=1) <= top
    image = np.empty((camera.height * camera.width, 3), dtype=np.float32)
    image[:] = srgb_to_linear(np.array(BACKGROUND, np.uint8))
    depth = np.full(len(image), np.inf, dtype=np.float32)
    shown = triangles.visible(camera, below & ~triangles.glass)
    light = _light(triangles.normals, shown.triangles, shown.points, house)
    image[shown.pixels] = triangles.looks(camera, shown) * light[:, None]
    depth[shown.pixels] = shown.depth
    panes = triangles.visible(camera, below & triangles.glass)
    front = panes.depth < depth[panes.pixels]
    seen, t = panes.pixels[front], panes.triangles[front]
    image[seen] = 0.7 * image[seen] + 0.3 * triangles.colours[t]
    return _small(image.reshape(camera.height, camera.width, 3))


def _light(normals: np.ndarray, t: np.ndarray, points: np.ndarray, house: House) -> np.ndarray:
    """Return the (p,) light of sky, ground and sun on points of triangles `t`, dark in corners."""
    up = 0.5 + 0.5 * normals[:, 1]
    light = _GROUND + (_SKY - _GROUND) * up + _SUNLIGHT * np.maximum(normals @ _SUN, 0.0)
    light = light.astype(np.float32)[t]
    flat = (normals[:, 1] > 0.9)[t]
    low = np.flatnonzero(~flat | (points[:, 1] < 0.01))
    to_corner = np.maximum(points[low, 1], 0.0)
    floor = np.flatnonzero(flat[low])
    to_corner[floor] = _wall_distance(house, points[low[floor]])
    light[low] *= 1.0 - _CORNER_DARK * np.exp(-to_corner / _CORNER_REACH)
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
    share = 1 / SUPERSAMPLING
    mean = cv2.resize(image, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)
    return np.asarray(np.round(linear_to_srgb(mean.clip(0, 1)) * 255).astype(np.uint8))
