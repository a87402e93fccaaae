"""rooms.jpg: every room as one sees it who stands in it, by rays (Embree), under baked light."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from plan2scene.colour import linear_to_srgb
from plan2scene.drawing import INK, PAPER, font
from plan2scene.house import House, SurfaceKey
from plan2scene.mesh.light import Light, bake_light, mean_colours
from plan2scene.mesh.parts import MeshPart
from plan2scene.mesh.raster import Camera, Soup, look_at, sample, soup_of, texels_per_metre
from plan2scene.mesh.rays import Rays
from plan2scene.mesh.textures import TileTexture
from plan2scene.mesh.traced import TracedScene, load_mitsuba
from plan2scene.plans.geometry import room_polygon

#: Metres above the floor; horizontal field of view, degrees; distance kept from walls, metres.
EYE_M, FOV_DEG, CLEAR_M = 1.5, 78.0, 0.35
#: Height and width of a picture in pixels, pictures in a row of the sheet.
SIZE, COLUMNS = (280, 420), 3
_FINER = 1.25  # pictures are drawn so many times larger and averaged down
_TEXEL_M = 0.2  # of the light
_STANDPOINTS = 10  # of the longest lines across a room, compared by what is seen
_LOOK_DOWN = 0.22  # how far below the eye one looks at 1 m
_SKY, _HORIZON = np.array([0.55, 0.70, 0.95]), np.array([0.90, 0.93, 0.97])
_BRIGHT = 0.42  # mean linear value that a picture is exposed to, within these factors
_EXPOSURE = (0.5, 1.5)
_KNEE = 0.75  # linear value from which highlights are compressed


def render_rooms(
    house: House,
    textures: Mapping[SurfaceKey, TileTexture],
    parts: Sequence[MeshPart],
    *,
    traced: bool = False,
) -> np.ndarray:
    """Return a sheet of a picture of each room, (h, w, 3) uint8 sRGB, see :func:`draw_rooms`."""
    names = [room.id for room in house.rooms]
    pictures = draw_rooms(house, textures, parts, names, traced=traced)
    if not pictures:
        return _sheet([np.full((*SIZE, 3), 200, np.uint8)], ["no ray tracer, or no texture"])
    return _sheet(pictures, names)


def draw_rooms(
    house: House,
    textures: Mapping[SurfaceKey, TileTexture],
    parts: Sequence[MeshPart],
    names: Sequence[str],
    *,
    traced: bool = False,
    light: Light | None = None,
) -> list[np.ndarray]:
    """Return a picture of each named room, `SIZE` uint8 sRGB; none where nothing can be lit.

    With `traced` by path tracing (:mod:`plan2scene.mesh.traced`) where Mitsuba is installed, else
    by `light`, which is baked where it is not given.
    """
    rays = Rays.of(parts)
    if rays is None:
        return []
    cameras = [camera_in(house, name, rays) for name in names]
    mi = load_mitsuba() if traced else None
    if mi is not None:
        scene = TracedScene(mi, house, parts, textures)
        return [_developed(scene.draw(camera), (1.0, 1.0)) for camera in cameras]
    light = light or bake_light(house, parts, mean_colours(textures), _TEXEL_M)
    if light is None:
        return []
    baked = _Scene(rays, textures, light)
    return [_developed(baked.draw(camera), _EXPOSURE) for camera in cameras]


def camera_in(house: House, room_id: str, rays: Rays) -> Camera:
    """Return a camera at eye level in a room, near a corner, that looks across it.

    Of the longest lines across the room the one along which most of it is seen: no door leaf
    stands before it.
    """
    room = house.room(room_id)
    polygon = room_polygon(room)
    height = house.level_of(room_id).elevation + min(EYE_M, 0.7 * room.height)
    cameras = [_camera(eye, target, height) for eye, target in standpoints(polygon)]
    return max(cameras, key=lambda camera: _openness(camera, rays))


def _camera(eye: np.ndarray, target: np.ndarray, height: float) -> Camera:
    """Return a camera at `eye` that looks towards `target`, (x, z) both, a little down."""
    size = (round(SIZE[0] * _FINER), round(SIZE[1] * _FINER))
    focal = size[1] / (2 * np.tan(np.radians(FOV_DEG) / 2))
    way = (target - eye) / max(float(np.linalg.norm(target - eye)), 1e-9)
    ahead = np.array([eye[0] + way[0], height - _LOOK_DOWN, eye[1] + way[1]])
    return look_at(np.array([eye[0], height, eye[1]]), ahead, focal, size, perspective=True)


def _openness(camera: Camera, rays: Rays) -> float:
    """Return how far one sees in the mean of a picture's directions, metres, no farther than 5."""
    ways = directions(camera, 20)
    return float(np.minimum(rays.distances(*_from(camera, ways)), 5.0).mean())


def directions(camera: Camera, step: int = 1) -> np.ndarray:
    """Return the unit directions (n, 3) of every `step`-th pixel's ray, row by row."""
    height, width = camera.size
    rows, columns = np.mgrid[step // 2 : height : step, step // 2 : width : step]
    x, y = columns - (width - 1) / 2, rows - (height - 1) / 2
    local = np.stack([x, y, np.full(x.shape, camera.scale)], axis=-1).reshape(-1, 3)
    return np.asarray((local / np.linalg.norm(local, axis=1, keepdims=True)) @ camera.rotation)


def _from(camera: Camera, ways: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return np.tile(camera.position, (len(ways), 1)), ways


def standpoints(polygon: BaseGeometry) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return where one may stand in a room and look at, (x, z) each: the longest clear lines."""
    free = polygon
    for clear in (CLEAR_M, CLEAR_M / 2, CLEAR_M / 4):
        smaller = polygon.buffer(-clear, join_style="mitre")
        if not smaller.is_empty:
            free = smaller
            break
    corners = np.unique(np.round(shapely.get_coordinates(free), 3), axis=0)
    room, middle = free.buffer(0.01), np.array(polygon.centroid.coords[0])
    lines = [
        (float(np.linalg.norm(b - a)), a, 0.5 * (b + middle))
        for a in corners
        for b in corners
        if room.covers(shapely.LineString([a, b])) and not np.allclose(a, b)
    ]
    lines.sort(key=lambda line: -line[0])
    if not lines:
        inside = np.array(free.representative_point().coords[0])
        return [(inside, inside + [1.0, 0.0])]
    return [(eye, target) for _, eye, target in lines[:_STANDPOINTS]]


class _Scene:
    """A house to be looked at: triangles with textures, and their light."""

    def __init__(
        self, rays: Rays, textures: Mapping[SurfaceKey, TileTexture], light: Light
    ) -> None:
        self.rays, self.light = rays, light
        self.soup: Soup = soup_of(rays.parts, textures)
        self.texels = texels_per_metre(self.soup)
        lights, uv = [], []
        for part in rays.parts:
            faces, own = part.mesh.faces, light.charts.get(part.name)
            plain = light.of_plain(part)[faces[:, 0]]
            lights.append(np.full((len(faces), 3), np.nan) if own else plain)
            uv.append(light.uv(part)[faces] if own else np.zeros((len(faces), 3, 2)))
        self.plain, self.light_uv = np.concatenate(lights), np.concatenate(uv)

    def draw(self, camera: Camera) -> np.ndarray:
        """Return a picture, (h, w, 3) float32 linear RGB, not exposed."""
        height, width = camera.size
        eyes, ways = _from(camera, directions(camera))
        hit = self.rays.hits(eyes, ways)
        image = _HORIZON + (_SKY - _HORIZON) * np.clip(ways[:, 1:2], 0, 1)
        seen = np.flatnonzero(hit >= 0)
        image[seen] = self._colours(hit[seen], eyes[seen], ways[seen], camera.scale)
        return np.asarray(image.reshape(height, width, 3), dtype=np.float32)

    def _colours(
        self, t: np.ndarray, eyes: np.ndarray, ways: np.ndarray, focal: float
    ) -> np.ndarray:
        """Return the linear colours (n, 3) of triangles `t` where rays meet them."""
        points, distance = self.rays.points(t, eyes, ways)
        weights = _barycentric(self.soup.corners[t], points)
        uv = np.einsum("nk,nkc->nc", weights, self.soup.uv[t])
        colour = self.soup.colours[t].astype(np.float32)
        facing = np.abs(np.einsum("ij,ij->i", ways, self.soup.normals[t]))
        footprint = self.texels[t] * distance / focal / np.sqrt(np.maximum(facing, 0.05))
        for number, levels in enumerate(self.soup.mipmaps):
            mine = np.flatnonzero(self.soup.texture[t] == number)
            if len(mine):
                colour[mine] = sample(levels, uv[mine], footprint[mine])
        light = self.plain[t]
        lit = np.flatnonzero(np.isnan(light[:, 0]))
        at = np.einsum("nk,nkc->nc", weights[lit], self.light_uv[t[lit]])
        light[lit] = sample([self.light.image], at, np.ones(len(lit)))
        return np.asarray(colour * light)


def _barycentric(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return the weights (n, 3) of the corners (n, 3, 3) of triangles at points (n, 3) on them."""
    ab, ac = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    ap = points - corners[:, 0]
    bb, bc, cc, pb, pc = (
        np.einsum("ij,ij->i", *pair) for pair in ((ab, ab), (ab, ac), (ac, ac), (ap, ab), (ap, ac))
    )
    area = np.maximum(bb * cc - bc**2, 1e-18)
    second, third = (cc * pb - bc * pc) / area, (bb * pc - bc * pb) / area
    return np.stack([1 - second - third, second, third], axis=1)


def _developed(image: np.ndarray, exposures: tuple[float, float]) -> np.ndarray:
    """Return a linear picture exposed, its highlights compressed, at `SIZE`, uint8 sRGB.

    Its mean becomes `_BRIGHT`, within the least and the greatest exposure.
    """
    image = cv2.resize(image, SIZE[::-1], interpolation=cv2.INTER_AREA)
    image = image * np.clip(_BRIGHT / max(float(image.mean()), 1e-6), *exposures)
    over = np.maximum(image - _KNEE, 0.0)
    image = np.minimum(image, _KNEE) + (1 - _KNEE) * over / (over + 1 - _KNEE)
    return np.asarray(np.round(linear_to_srgb(image.clip(0, 1)) * 255).astype(np.uint8))


def _sheet(pictures: Sequence[np.ndarray], names: Sequence[str]) -> np.ndarray:
    """Return pictures with their names below, in rows."""
    from PIL import Image, ImageDraw

    gap, text = 8, 24
    columns = min(COLUMNS, len(pictures))
    rows = -(-len(pictures) // columns)
    high, wide = SIZE[0] + text + gap, SIZE[1] + gap
    sheet = Image.new("RGB", (columns * wide + gap, rows * high + gap), PAPER)
    draw = ImageDraw.Draw(sheet)
    for number, (picture, name) in enumerate(zip(pictures, names, strict=True)):
        left, top = gap + number % columns * wide, gap + number // columns * high
        sheet.paste(Image.fromarray(picture), (left, top))
        draw.text((left, top + SIZE[0] + 4), name, fill=INK, font=font(15))
    return np.asarray(sheet)
