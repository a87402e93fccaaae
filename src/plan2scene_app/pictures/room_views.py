"""rooms.jpg: every room as one sees it who stands in it, under baked light."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from plan2scene.camera import Camera, focal_of
from plan2scene.colour import linear_to_srgb
from plan2scene.drawing import INK, PAPER, font
from plan2scene.house import House, SurfaceKey
from plan2scene.mesh.baking import Light, bake_light, compressed, even_light, mean_colours
from plan2scene.mesh.parts import MeshPart
from plan2scene.mesh.rays import Rays
from plan2scene.mesh.texture_files import TileTexture
from plan2scene.plans.geometry import room_polygon
from plan2scene_app.pictures.path_tracing import TracedScene, load_mitsuba
from plan2scene_app.pictures.renderer import Triangles, sample


@dataclass(frozen=True)
class RoomViewSettings:
    """How rooms are pictured."""

    size: tuple[int, int] = (280, 420)  #: height and width of a picture, pixels
    finer: float = 1.25  #: pictures are drawn so many times larger and averaged down
    columns: int = 3  #: pictures in a row of the sheet
    eye_m: float = 1.5  #: of the camera, above the floor
    fov_deg: float = 78.0  #: horizontal field of view
    clear_m: float = 0.35  #: distance kept from walls
    look_down: float = 0.22  #: metres below the eye that one looks at 1 m ahead
    standpoints: int = 10  #: of the longest lines across a room, compared by what is seen
    far_m: float = 5.0  #: distances beyond this count as this when standpoints are compared
    texel_m: float = 0.2  #: of the light
    sky: tuple[float, float, float] = (0.55, 0.70, 0.95)  #: linear RGB overhead
    horizon: tuple[float, float, float] = (0.90, 0.93, 0.97)  #: linear RGB
    brightness: float = 0.42  #: mean linear value that a picture is exposed to,
    exposures: tuple[float, float] = (0.5, 1.5)  #: within these factors


SETTINGS = RoomViewSettings()


def render_rooms(
    house: House,
    textures: Mapping[SurfaceKey, TileTexture],
    parts: Sequence[MeshPart],
    *,
    traced: bool = False,
) -> np.ndarray:
    """Return a sheet of a picture of each room, (h, w, 3) uint8 sRGB, see :func:`room_pictures`."""
    names = [room.id for room in house.rooms]
    return _sheet(room_pictures(house, textures, parts, names, traced=traced), names)


def room_pictures(
    house: House,
    textures: Mapping[SurfaceKey, TileTexture],
    parts: Sequence[MeshPart],
    names: Sequence[str],
    *,
    traced: bool = False,
    light: Light | None = None,
) -> list[np.ndarray]:
    """Return a picture of each named room, (h, w, 3) uint8 sRGB of `RoomViewSettings.size`.

    With `traced` by path tracing (:mod:`.path_tracing`) where Mitsuba is installed, else
    by `light`, which is baked where it is not given; even where it cannot be baked.
    """
    rays = Rays.of(parts)
    cameras = [camera_in(house, name, rays) for name in names]
    mi = load_mitsuba() if traced else None
    if mi is not None:
        scene = TracedScene(mi, house, parts, textures)
        return [_developed(scene.draw(camera), (1.0, 1.0)) for camera in cameras]
    light = light or bake_light(house, parts, mean_colours(textures), SETTINGS.texel_m)
    baked = _LitTriangles(parts, textures, light or even_light(house))
    return [_developed(baked.draw(camera), SETTINGS.exposures) for camera in cameras]


def camera_in(house: House, room_id: str, rays: Rays | None) -> Camera:
    """Return a camera at eye level in a room, near a corner, that looks across it.

    Of the longest lines across the room the one along which most of it is seen: no door leaf
    stands before it. Without `rays` the longest.
    """
    room = house.room(room_id)
    polygon = room_polygon(room)
    height = house.level_of(room_id).elevation + min(SETTINGS.eye_m, 0.7 * room.height)
    cameras = [_camera(eye, target, height) for eye, target in standpoints(polygon)]
    if rays is None:
        return cameras[0]
    return max(cameras, key=lambda camera: _openness(camera, rays))


def _camera(eye: np.ndarray, target: np.ndarray, height: float) -> Camera:
    """Return a camera at `eye` that looks towards `target`, (x, z) both, a little down."""
    size = (round(SETTINGS.size[0] * SETTINGS.finer), round(SETTINGS.size[1] * SETTINGS.finer))
    focal = focal_of(np.radians(SETTINGS.fov_deg), size[1])
    way = (target - eye) / max(float(np.linalg.norm(target - eye)), 1e-9)
    ahead = np.array([eye[0] + way[0], height - SETTINGS.look_down, eye[1] + way[1]])
    return Camera.look_at(np.array([eye[0], height, eye[1]]), ahead, focal, size)


def _openness(camera: Camera, rays: Rays) -> float:
    """Return how far one sees in the mean of a picture's directions, metres."""
    ways = _directions(camera, 20).reshape(-1, 3)
    distances = rays.distances(np.tile(camera.position, (len(ways), 1)), ways)
    return float(np.minimum(distances, SETTINGS.far_m).mean())


def _directions(camera: Camera, step: int = 1) -> np.ndarray:
    """Return the unit directions (rows, columns, 3) of every `step`-th pixel's ray."""
    rows, columns = np.mgrid[step // 2 : camera.height : step, step // 2 : camera.width : step]
    return camera.rays(np.stack([columns, rows], axis=-1))


def standpoints(polygon: BaseGeometry) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return where one may stand in a room and look at, (x, z) each: the longest clear lines."""
    free = polygon
    for share in (1, 2, 4):
        smaller = polygon.buffer(-SETTINGS.clear_m / share, join_style="mitre")
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
    return [(eye, target) for _, eye, target in lines[: SETTINGS.standpoints]]


class _LitTriangles:
    """The opaque triangles of a house with their light; the sky is behind its windows."""

    def __init__(
        self,
        parts: Sequence[MeshPart],
        textures: Mapping[SurfaceKey, TileTexture],
        light: Light,
    ) -> None:
        opaque = [part for part in parts if part.material != "glass"]
        self.triangles, self.light = Triangles.of(opaque, textures), light
        lights, uv = [], []
        for part in opaque:
            faces, own = part.mesh.faces, light.charts.get(part.name)
            plain = light.of_plain(part)[faces[:, 0]]
            lights.append(np.full((len(faces), 3), np.nan) if own else plain)
            uv.append(light.uv(part)[faces] if own else np.zeros((len(faces), 3, 2)))
        self.plain, self.light_uv = np.concatenate(lights), np.concatenate(uv)

    def draw(self, camera: Camera) -> np.ndarray:
        """Return a picture, (h, w, 3) float32 linear RGB, not exposed."""
        fragments = self.triangles.visible(camera, np.ones(len(self.plain), dtype=bool))
        upward = np.clip(_directions(camera)[..., 1:2], 0, 1)
        horizon, sky = np.array(SETTINGS.horizon), np.array(SETTINGS.sky)
        image = (horizon + (sky - horizon) * upward).astype(np.float32)
        light = self.plain[fragments.triangles]
        baked = np.isnan(light[:, 0])
        at = fragments.at(self.light_uv)[baked]
        light[baked] = sample([self.light.image], at, np.ones(len(at)))
        image.reshape(-1, 3)[fragments.pixels] = self.triangles.looks(camera, fragments) * light
        return image


def _developed(image: np.ndarray, exposures: tuple[float, float]) -> np.ndarray:
    """Return a linear picture exposed, its highlights compressed, at `SETTINGS.size`, uint8 sRGB.

    Its mean becomes `SETTINGS.brightness`, within the least and the greatest exposure.
    """
    image = cv2.resize(image, SETTINGS.size[::-1], interpolation=cv2.INTER_AREA)
    image = image * np.clip(SETTINGS.brightness / max(float(image.mean()), 1e-6), *exposures)
    return np.asarray(np.round(linear_to_srgb(compressed(image).clip(0, 1)) * 255).astype(np.uint8))


def _sheet(pictures: Sequence[np.ndarray], names: Sequence[str]) -> np.ndarray:
    """Return pictures with their names below, in rows."""
    from PIL import Image, ImageDraw

    gap, text = 8, 24
    columns = min(SETTINGS.columns, len(pictures))
    rows = -(-len(pictures) // columns)
    high, wide = SETTINGS.size[0] + text + gap, SETTINGS.size[1] + gap
    sheet = Image.new("RGB", (columns * wide + gap, rows * high + gap), PAPER)
    draw = ImageDraw.Draw(sheet)
    for number, (picture, name) in enumerate(zip(pictures, names, strict=True)):
        left, top = gap + number % columns * wide, gap + number // columns * high
        sheet.paste(Image.fromarray(picture), (left, top))
        draw.text((left, top + SETTINGS.size[0] + 4), name, fill=INK, font=font(15))
    return np.asarray(sheet)
