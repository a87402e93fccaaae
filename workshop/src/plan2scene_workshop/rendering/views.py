"""Views like those of listings: the camera stands near the walls and looks across the room."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely

from plan2scene.camera import Camera, as_rows, focal_of
from plan2scene.errors import InputError
from plan2scene.house import House, Room
from plan2scene.plans.geometry import room_polygon
from plan2scene.seeds import derive_seed, generator
from plan2scene_workshop.rendering.geometry import Array

EYE_HEIGHT = (1.2, 1.7)  #: metres
FIELD_OF_VIEW_DEG = (50.0, 90.0)  #: horizontal
MAX_PITCH_DEG, MAX_ROLL_DEG = 8.0, 2.0
WALL_CLEARANCE = 0.3  #: least distance of a camera from the room's polygon, metres
_CANDIDATES = 160
#: Rows and columns of the rays that score a candidate.
_JUDGED = (9, 13)


@dataclass(frozen=True)
class View:
    """A camera in a room.

    `position` is (x, y, z) in metres; `yaw` 0 looks along +z and turns towards +x, `pitch` is
    positive upwards, `roll` positive when the camera turns clockwise; all in radians. `fov` is
    the field of view along the longer side of a picture in radians.
    """

    room_id: str
    position: tuple[float, float, float]
    yaw: float
    pitch: float
    roll: float
    fov: float
    seed: int

    def rotation(self) -> Array:
        """Return the (3, 3) world-to-camera rotation in OpenCV axes (x right, y down, z ahead)."""
        sy, cy = np.sin(self.yaw), np.cos(self.yaw)
        sp, cp = np.sin(self.pitch), np.cos(self.pitch)
        forward = np.array([sy * cp, sp, cy * cp])
        right = np.array([-cy, 0.0, sy])
        down = np.cross(forward, right)
        sr, cr = np.sin(self.roll), np.cos(self.roll)
        return np.stack([cr * right + sr * down, cr * down - sr * right, forward])

    def camera(self, size: tuple[int, int]) -> Camera:
        """Return the camera of a picture of (height, width) pixels, its centre in the middle."""
        height, width = size
        return Camera(
            width,
            height,
            focal_of(self.fov, max(size)),
            (width - 1) / 2,
            (height - 1) / 2,
            as_rows(self.rotation()),
            position=self.position,
        )


def plan_views(house: House, rooms: Sequence[str], count: int, seed: int) -> list[View]:
    """Return `count` views of the named rooms; larger rooms come first and get more views.

    Every room gets a view if `count` allows, and the views of a room differ from one another.
    InputError if a room is not in the house or is too narrow to stand in.
    """
    known = {room.id: room for room in house.rooms}
    for room_id in rooms:
        if room_id not in known:
            raise InputError("a room of the plan", room_id, house=house.id, room=room_id)
    chosen = sorted(
        (known[room_id] for room_id in rooms), key=lambda r: (-room_polygon(r).area, r.id)
    )
    shares = dict.fromkeys((room.id for room in chosen), 0)
    for _ in range(count if chosen else 0):
        room = max(chosen, key=lambda r: room_polygon(r).area ** 0.5 / (1e-9 + 2 * shares[r.id]))
        shares[room.id] += 1
    views: list[View] = []
    for room in chosen:
        views += _room_views(house, room, shares[room.id], seed)
    return views


def _room_views(house: House, room: Room, count: int, seed: int) -> list[View]:
    if count == 0:
        return []
    rng = generator(seed, house.id, room.id, "views")
    polygon = room_polygon(room)
    inner = polygon.buffer(-WALL_CLEARANCE - 0.05)
    if inner.is_empty:
        raise InputError(
            "a room at least 0.7 m wide to photograph",
            f"an area of {polygon.area:.2f} square metres",
            house=house.id,
            room=room.id,
        )
    candidates = [_candidate(room, inner, rng) for _ in range(_CANDIDATES)]
    scores = np.array([_score(view, room, polygon) for view in candidates])
    views: list[View] = []
    for index in range(count):
        best = int(np.argmax(scores + rng.uniform(0, 0.25, len(scores))))
        view = candidates[best]
        view_seed = derive_seed(seed, house.id, room.id, "view", index)
        views.append(replace(view, seed=view_seed))
        for i, other in enumerate(candidates):
            turn = abs(np.angle(np.exp(1j * (other.yaw - view.yaw))))
            away = float(np.hypot(*(np.array(other.position) - view.position)[[0, 2]]))
            scores[i] -= 0.8 * np.exp(-turn / 0.6) + 0.4 * np.exp(-away / 1.0)
    return views


def _candidate(room: Room, inner: shapely.Polygon, rng: np.random.Generator) -> View:
    """Draw a position near the border of the free floor and a heading across the room."""
    rim = inner.boundary
    stand = rim.interpolate(rng.uniform(0, rim.length))
    centre = inner.representative_point() if inner.geom_type == "Polygon" else inner.centroid
    to_centre = np.array([centre.x - stand.x, centre.y - stand.y])
    distance = float(np.hypot(*to_centre))
    step = min(abs(rng.normal(0, 0.25)), 0.8 * distance)
    x, z = np.array([stand.x, stand.y]) + to_centre / max(distance, 1e-9) * step
    if not inner.covers(shapely.Point(x, z)):
        x, z = stand.x, stand.y
    yaw = np.arctan2(to_centre[0], to_centre[1]) + rng.normal(0, 0.5)
    low, high = np.radians(FIELD_OF_VIEW_DEG)
    pitch = np.clip(rng.normal(-0.05, 0.05), -1, 1) if rng.random() < 0.85 else 0.0
    limit, tilt = np.radians((MAX_PITCH_DEG, MAX_ROLL_DEG))
    return View(
        room.id,
        (float(x), float(rng.uniform(*EYE_HEIGHT)), float(z)),
        float(np.angle(np.exp(1j * yaw))),
        float(np.clip(pitch, -limit, limit)),
        float(np.clip(rng.normal(0, tilt / 3), -tilt, tilt)),
        float(low + (high - low) * rng.beta(2, 1.6)),
        0,
    )


def _score(view: View, room: Room, polygon: shapely.Polygon) -> float:
    """Return the score of a view of the empty room: it prefers depth, floor and ceiling in view.

    Walls close to the camera lower it.
    """
    rows, columns = _JUDGED
    half = np.tan(view.fov / 2)
    u, v = np.meshgrid(np.linspace(-half, half, columns), np.linspace(-0.75, 0.75, rows) * half)
    rays = np.stack([u, v, np.ones_like(u)], -1) @ view.rotation()
    flat = np.hypot(rays[..., 0], rays[..., 2])
    middle = rays[rows // 2]
    reach = np.array([_reach(polygon, view, ray) for ray in middle])
    slope = rays[..., 1] / flat
    height = view.position[1] + slope * reach[None]
    floor, ceiling = float((height < 0).mean()), float((height > room.height).mean())
    depth = float(np.minimum(reach, 6.0).mean())
    score = 1.3 * min(floor, 0.3) / 0.3 + 0.5 * min(ceiling, 0.12) / 0.12
    near = 1.5 * float((reach < 0.7).mean()) + float((reach < 1.3).mean())
    return score + 0.5 * depth / np.sqrt(polygon.area) - near


def _reach(polygon: shapely.Polygon, view: View, ray: Array) -> float:
    """Return the distance in plan from the camera to the room's outline along a ray."""
    x, _, z = view.position
    scale = 40.0 / float(np.hypot(ray[0], ray[2]))
    line = shapely.LineString([(x, z), (x + ray[0] * scale, z + ray[2] * scale)])
    crossing = line.intersection(polygon.boundary)
    return 40.0 if crossing.is_empty else float(crossing.distance(shapely.Point(x, z)))
