"""rooms.jpg: a picture of every room, as seen by a person who stands in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
import shapely.ops
from shapely.geometry.base import BaseGeometry

from plan2scene.camera import Camera, focal_of
from plan2scene.house import House, Room
from plan2scene.mesh.rays import Rays
from plan2scene.plans.geometry import point_along, room_polygon
from plan2scene_app.drawing import INK, PAPER, font_for, room_labels
from plan2scene_app.pictures.lit_picture import Painter, directions
from plan2scene_app.pictures.renderer import look_at


@dataclass(frozen=True)
class RoomViewSettings:
    """How the camera of a room's picture is chosen."""

    size: tuple[int, int] = (280, 420)  #: height and width of a picture, pixels
    columns: int = 3  #: pictures in a row of the sheet
    step_px: int = 16  #: distance of the pixels whose rays measure what a picture shows
    eye_m: float = 1.5  #: height of the camera above the floor
    fov_deg: float = 88.0  #: horizontal field of view, as in wide-angle photos of rooms
    clear_m: float = 0.35  #: distance kept from walls
    #: How far the camera looks down: metres below the eye at 1 m ahead. Large rooms use the first
    #: value. Rooms below `close_m2` use the value that shows most, those below `small_m2` never the
    #: first.
    look_down: tuple[float, ...] = (0.22, 0.5, 0.9)
    close_m2: float = 8.0
    standpoints: int = 24  #: largest number of lines across a room that are compared, longest first
    small_m2: float = 2.0  #: smaller rooms are seen from their doors
    door_m: float = 0.05  #: distance of such a camera from the room's edge
    near_m: float = 0.6  #: surfaces of rooms nearer than this stand in the way
    near_thing_m: float = 1.3  #: other things nearer than this stand in the way
    most_near: float = 0.08  #: share of a picture that things in the way may fill
    least_facing: float = 0.1  #: lower bound of the cosine by which a seen area is divided
    windows: float = 0.6  #: weight of all windows; the whole floor and all walls each have weight 1
    wide_m: float = 1.25  #: wider doors to the outside, of a garage or patio, count as windows
    panes: tuple[float, ...] = (0.25, 0.75)  #: points along a window that are tested if seen
    least_pane: float = 0.25  #: cosine: a window that is seen at a flatter angle does not count


SETTINGS = RoomViewSettings()


def render_rooms(house: House, rays: Rays | None, painter: Painter) -> np.ndarray:
    """Return a sheet of a picture of each room, (h, w, 3) uint8 sRGB.

    A small room is left out if near things, such as its door's leaf, fill too much of its picture.
    """
    cameras = {room.id: camera_in(house, room.id, rays) for room in house.rooms}
    for room in house.rooms:
        small = room_polygon(room).area < SETTINGS.small_m2 and len(cameras) > 1
        if (
            rays is not None
            and small
            and _seen_area(cameras[room.id], room.id, rays)[1] >= 2 * SETTINGS.most_near
        ):
            del cameras[room.id]
    labels = room_labels(house)
    pictures = [painter(camera) for camera in cameras.values()]
    return _sheet(pictures, [labels[room] for room in cameras])


def camera_in(house: House, room_id: str, rays: Rays | None) -> Camera:
    """Return a camera at eye level in a room that shows most of its floor, walls and windows.

    It stands at the end of one of the longest lines across the room; in a small room it stands in a
    door. Pictures with too many near things get a low score. Without `rays` the first line is used.
    """
    room = house.room(room_id)
    polygon = room_polygon(room)
    height = house.level_of(room_id).elevation + min(SETTINGS.eye_m, 0.7 * room.height)
    small = polygon.area < SETTINGS.small_m2
    lines = (_doorways(house, room) if small else []) or standpoints(polygon)
    close = polygon.area < SETTINGS.close_m2
    downs = SETTINGS.look_down[small:] if close else SETTINGS.look_down[:1]
    cameras = [_camera(*line, height, down) for down in downs for line in lines]
    if rays is None:
        return cameras[0]
    panes = _panes(house, room_id)

    def worth(camera: Camera) -> float:
        (floor, walls), near = _seen_area(camera, room_id, rays)
        score = floor / polygon.area + walls / (polygon.length * room.height)
        score += SETTINGS.windows * _seen_share(camera, *panes, rays)
        return score if near < SETTINGS.most_near else 1e-3 * score * (1.0 - near)

    return max(cameras, key=worth)


def _camera(eye: np.ndarray, target: np.ndarray, height: float, look_down: float) -> Camera:
    """Return a camera at `eye` that looks towards `target`, both (x, z), and `look_down` down."""
    focal = focal_of(np.radians(SETTINGS.fov_deg), SETTINGS.size[1])
    way = (target - eye) / max(float(np.linalg.norm(target - eye)), 1e-9)
    ahead = np.array([eye[0] + way[0], height - look_down, eye[1] + way[1]])
    return look_at(np.array([eye[0], height, eye[1]]), ahead, focal, SETTINGS.size)


def _seen_area(camera: Camera, room_id: str, rays: Rays) -> tuple[tuple[float, float], float]:
    """Return the seen area (m2) of a room's floor and walls, and the share of near pixels."""
    ways = directions(camera, SETTINGS.step_px).reshape(-1, 3)
    eyes = np.tile(camera.position, (len(ways), 1))
    triangles = rays.hits(eyes, ways)
    hit = np.flatnonzero(triangles >= 0)
    _, metres = rays.points(triangles[hit], eyes[hit], ways[hit])
    surfaces = [rays.parts[number].surface for number in rays.part[triangles[hit]]]
    thing = np.array([surface is None for surface in surfaces])
    kinds = np.array([s.kind if s is not None and s.room_id == room_id else "" for s in surfaces])
    corners = rays.triangles[triangles[hit]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    facing = np.abs(np.einsum("ij,ij->i", normals, ways[hit]))
    # A pixel's solid angle shrinks with the third power of its cosine to the axis.
    angle = (ways[hit] @ camera.matrix[2]) ** 3 * (SETTINGS.step_px / camera.focal_px) ** 2
    area = metres**2 * angle / np.maximum(facing, SETTINGS.least_facing)
    near = metres < np.where(thing, SETTINGS.near_thing_m, SETTINGS.near_m)
    floor, walls = (float(area[kinds == kind].sum()) for kind in ("floor", "wall"))
    return (floor, walls), float(near.sum() / len(ways))


def _panes(house: House, room_id: str) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, 3) on a room's windows and wide outer doors, and their normals (n, 3)."""
    floor = house.level_of(room_id).elevation
    outside = {room.id for room in house.rooms if room.open_air or room.id == room_id}
    points, normals = [], []
    for wall in house.walls:
        (x0, z0), (x1, z1) = wall.start, wall.end
        for opening in wall.openings if room_id in wall.room_ids else ():
            wide = opening.kind == "door" and opening.end - opening.start > SETTINGS.wide_m
            if opening.kind == "window" or (wide and outside.issuperset(wall.room_ids)):
                y = floor + 0.4 * opening.bottom + 0.6 * opening.top
                ways = (opening.start + s * (opening.end - opening.start) for s in SETTINGS.panes)
                points += [(x, y, z) for x, z in (point_along(wall, way) for way in ways)]
                normal = np.array([z0 - z1, 0.0, x1 - x0]) / wall.length
                normals += [normal] * len(SETTINGS.panes)
    return np.array(points).reshape(-1, 3), np.array(normals).reshape(-1, 3)


def _seen_share(camera: Camera, points: np.ndarray, normals: np.ndarray, rays: Rays) -> float:
    """Return the share of points (n, 3) that a picture shows, not too flat; 0 if there are none."""
    if not len(points):
        return 0.0
    ways = points - camera.position
    distances = np.linalg.norm(ways, axis=1)
    eyes = np.tile(camera.position, (len(points), 1))
    free = rays.distances(eyes, ways / distances[:, None]) > distances - SETTINGS.clear_m
    faces = np.abs((ways * normals).sum(axis=1)) >= SETTINGS.least_pane * distances
    pixels = camera.project(points)  # NaN behind the camera
    within = (pixels > 0).all(axis=1) & (pixels < [camera.width, camera.height]).all(axis=1)
    return float((within & free & faces).mean())


def _doorways(house: House, room: Room) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return lines (eye, target), (x, z) each, from a room's doors and passages to its middle."""
    polygon = room_polygon(room)
    inside, middle = polygon.buffer(-SETTINGS.door_m), np.array(polygon.centroid.coords[0])
    lines = []
    for wall in house.walls:
        start, end = np.array(wall.start), np.array(wall.end)
        for opening in wall.openings if room.id in wall.room_ids and not inside.is_empty else ():
            if opening.kind == "window":
                continue
            for share in (0.25, 0.5, 0.75):
                at = opening.start + share * (opening.end - opening.start)
                place = shapely.Point(start + at / wall.length * (end - start))
                eye = np.array(shapely.ops.nearest_points(inside, place)[0].coords[0])
                lines.append((eye, middle))
    return lines


def standpoints(polygon: BaseGeometry) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return lines (eye, target), (x, z) each, along the longest clear lines across a room."""
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
        draw.text((left, top + SETTINGS.size[0] + 4), name, fill=INK, font=font_for(name, 15))
    return np.asarray(sheet)
