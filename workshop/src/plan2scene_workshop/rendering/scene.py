"""The scene of one photographed room with furniture, and of the rooms behind its doors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray

from plan2scene.errors import InputError
from plan2scene.house import House, Room, SurfaceKey
from plan2scene.materials import Material
from plan2scene.plans.geometry import room_polygon
from plan2scene.plans.wall_sides import FaceOpening
from plan2scene.seeds import generator
from plan2scene_workshop.rendering.closets import add_closets, draw_leaf
from plan2scene_workshop.rendering.coverings import add_covering
from plan2scene_workshop.rendering.decor import PANELLING, Decor
from plan2scene_workshop.rendering.fixtures import (
    DoorState,
    add_casing,
    add_curtains,
    add_leaf,
    add_window,
    draw_door,
)
from plan2scene_workshop.rendering.furniture import furnish_room
from plan2scene_workshop.rendering.geometry import Geometry
from plan2scene_workshop.rendering.interiors import GLOW
from plan2scene_workshop.rendering.lights import (
    add_lamps,
    draw_light,
    lamp_finish,
    sky_finish,
    view_outside,
)
from plan2scene_workshop.rendering.linings import line_room
from plan2scene_workshop.rendering.palette import (
    FABRICS,
    WOODS,
    Palette,
    clutter_finishes,
    draw_palette,
    pick,
)
from plan2scene_workshop.rendering.randomised import randomised_finishes
from plan2scene_workshop.rendering.shell import (
    Plane,
    WallFace,
    add_room_shell,
    room_planes,
    wall_faces,
)
from plan2scene_workshop.rendering.tracer import Finish
from plan2scene_workshop.rendering.views import View

#: Materials of the view outside the windows, of the photographed room and of other rooms.
SKY = ("sky", "sky beyond")
#: Rooms up to this number of openings away from the photographed room are built.
REACH = 2
#: Largest number of planes in a mask (255 is none).
MAX_PLANES = 254
#: A door stays closed if a camera is closer than its width plus this, metres.
LEAF_CLEARANCE = 0.7


@dataclass(frozen=True)
class RoomScene:
    """Geometry, finishes by material name, planes by the truth's indices, and the view outside.

    `outside` is a panorama as of :func:`.lights.view_outside`. It is visible where a ray hits a
    mesh with a material of :data:`SKY`.
    """

    geometry: Geometry
    finishes: dict[str, Finish]
    planes: tuple[Plane, ...]
    outside: NDArray[np.float32]


def build_room_scene(
    house: House,
    room_id: str,
    materials: Mapping[SurfaceKey, Material],
    accents: Mapping[str, Material],
    views: Sequence[View],
    seed: int,
    *,
    randomised: bool = False,
    decor: Decor | None = None,
) -> RoomScene:
    """Build the scene of the room; furniture and open doors keep clear of the `views`.

    Doors, furniture and colours depend on the house and the seed, and on the views only where a
    camera must be kept clear. If `randomised`, the room and the rooms behind its doors have the
    textiles and clutter of :mod:`.randomised`. With a `decor`, the rooms have its textiles,
    furniture, light and view outside.

    InputError if a surface of a room in sight has no material.
    """
    palette = decor.palette if decor else draw_palette(generator(seed, house.id, "palette"))
    builder = _Builder(house, room_id, palette, accents, views, seed, randomised, decor)
    for hops, rooms in enumerate(_rooms_in_sight(house, room_id, builder.doors)):
        for room in rooms:
            builder.add_room(room, materials, hops)
    if decor:
        builder.finishes |= decor.shop.finishes
    outside = decor.outside() if decor else view_outside(generator(seed, house.id, "outside"))
    return RoomScene(builder.geometry, builder.finishes, tuple(builder.planes), outside)


def _rooms_in_sight(
    house: House, room_id: str, doors: Mapping[str, DoorState | None]
) -> list[list[Room]]:
    """Return the room, then the rooms behind its open doors and passages, and so on up to REACH."""
    rings = [[house.room(room_id)]]
    seen = {room_id}
    for _ in range(REACH):
        ring = []
        for room in rings[-1]:
            for door in house.doors:
                if room.id not in (door.room_a, door.room_b) or door.room_b is None:
                    continue
                other = door.room_b if room.id == door.room_a else door.room_a
                state = doors.get(door.opening_id)
                if other not in seen and (state is None or state.angle > 0):
                    seen.add(other)
                    ring.append(house.room(other))
        rings.append(ring)
    return rings


class _Builder:
    """Adds rooms to one geometry; the leaf of each door is added once."""

    def __init__(
        self,
        house: House,
        room_id: str,
        palette: Palette,
        accents: Mapping[str, Material],
        views: Sequence[View],
        seed: int,
        randomised: bool,
        decor: Decor | None,
    ) -> None:
        self.house, self.palette, self.accents = house, palette, accents
        self.views, self.seed, self.randomised = views, seed, randomised
        self.geometry = Geometry()
        self.finishes = clutter_finishes(house.id, seed)
        self.room_id, self.decor = room_id, decor
        if decor:
            self.finishes |= decor.finishes()
        if randomised:
            textiles = generator(seed, house.id, self.room_id, "textiles")
            self.finishes |= randomised_finishes(textiles)
        self.planes: list[Plane] = []
        self.doors = self._door_states()
        self._hung: set[str] = set()
        rng = generator(seed, house.id, "joinery")
        wood = str(rng.choice(WOODS)) if rng.random() < 0.3 else "paint"
        self._leaf_look = (wood, palette.door, int(rng.choice([0, 1, 2, 3])))

    def _door_states(self) -> dict[str, DoorState | None]:
        """Return the state of every door of the house; None for a passage."""
        inner = {door.opening_id for door in self.house.doors if door.room_b is not None}
        states: dict[str, DoorState | None] = {}
        for wall in self.house.walls:
            for opening in wall.openings:
                if opening.kind == "door":
                    rng = generator(self.seed, self.house.id, "door", opening.id)
                    state = draw_door(rng, inner=opening.id in inner)
                    if self._near_camera(wall.start, wall.end, opening.start, opening.end):
                        state = DoorState(0.0, state.hinge_left, state.swings_in)
                    states[opening.id] = state
                elif opening.kind == "passage":
                    states[opening.id] = None
        return states

    def _near_camera(
        self, start: tuple[float, float], end: tuple[float, float], low: float, high: float
    ) -> bool:
        """Return whether a camera is in or near the circle that an open leaf sweeps."""
        a, b = np.array(start), np.array(end)
        along = (b - a) / max(float(np.hypot(*(b - a))), 1e-9)
        middle = a + along * (low + high) / 2
        limit = (high - low) + LEAF_CLEARANCE
        return any(
            float(np.hypot(view.position[0] - middle[0], view.position[2] - middle[1])) < limit
            for view in self.views
        )

    def add_room(self, room: Room, materials: Mapping[SurfaceKey, Material], hops: int) -> None:
        """Add a room `hops` openings away from the photographed one."""
        faces = wall_faces(self.house, room)
        if len(self.planes) + 2 + len(faces) > MAX_PLANES:
            raise InputError(
                f"at most {MAX_PLANES} planes in sight", "more", house=self.house.id, room=room.id
            )
        for key in room.surface_keys():
            if key not in materials:
                raise InputError(
                    f"a material of {key.surface}", "none", house=self.house.id, room=room.id
                )
            self.finishes["/".join(key)] = surface_finish(materials[key])
        special = self._accent_walls(room, faces)
        add_room_shell(self.geometry, room, faces, len(self.planes), special, self.palette.trim)
        self.planes += room_planes(room, faces)
        for face in faces:
            for hole in face.openings:
                self._add_opening(face, hole, hops)
        panes = [h for face in faces for h in face.openings if _is_window(h)]
        self._light(room, hops, sum((h.right - h.left) * (h.top - h.bottom) for h in panes))
        if self.decor and not self.decor.listing:
            rng = generator(self.seed, self.house.id, room.id, "linings")
            line_room(self.geometry, room, faces, rng, glow=GLOW, panelling=PANELLING)
        if self.decor and self.decor.joinery:
            rng = generator(self.seed, self.house.id, room.id, "closets")
            add_closets(self.geometry, faces, self.palette, rng)
        if hops < REACH:
            rng = generator(self.seed, self.house.id, room.id, "furniture")
            cameras = [shapely.Point(v.position[0], v.position[2]) for v in self.views]
            if self.decor:
                self.decor.furnisher().furnish(self.geometry, room, faces, rng, cameras)
                return
            furnish_room(
                self.geometry, room, faces, self.palette, rng, cameras, random_room=self.randomised
            )

    def _accent_walls(self, room: Room, faces: tuple[WallFace, ...]) -> dict[str, str]:
        """Return the material names of accent walls by wall id.

        The key in `accents` is `room id/wall id`, or the wall's id.
        """
        special = {}
        for face in faces:
            for name in (f"{room.id}/{face.wall.id}", face.wall.id):
                if name in self.accents:
                    special[face.wall.id] = f"accent {name}"
                    self.finishes[f"accent {name}"] = surface_finish(self.accents[name])
                    break
        return special

    def _add_opening(self, face: WallFace, hole: FaceOpening, hops: int) -> None:
        rng = generator(self.seed, self.house.id, face.room_id, hole.opening.id)
        covered = self.decor.covered if self.decor else 0.0
        if covered and _is_window(hole) and rng.random() < covered:
            add_window(self.geometry, face, hole, self.palette, rng, SKY[min(hops, 1)], 0.0)
            add_covering(self.geometry, face, hole, self.palette, rng)
            return
        if _is_window(hole):
            drop = float(rng.uniform(0.15, 0.6)) if rng.random() < 0.2 else 0.0
            add_window(self.geometry, face, hole, self.palette, rng, SKY[min(hops, 1)], drop)
            curtains = 0.15 if self.decor and self.decor.emptied else 0.55
            if drop == 0.0 and rng.random() < curtains:
                material = str(rng.choice([*FABRICS, "fabric", "fabric"]))
                colour = pick(rng, self.palette.fabrics)
                add_curtains(self.geometry, face, hole, material, colour, rng)
            return
        if hole.opening.kind == "door":
            add_casing(self.geometry, face, hole, self.palette.trim)
            state = self.doors[hole.opening.id]
            if hole.opening.id not in self._hung and state is not None:
                self._hung.add(hole.opening.id)
                far = hops == REACH
                state = DoorState(0.0, True, True) if far else state
                look = self._leaf_look
                if self.decor and self.decor.joinery and rng.random() < 0.5:
                    look = (*draw_leaf(rng, self.palette), int(rng.choice([0, 1, 2, 3])))
                add_leaf(self.geometry, face, hole, state, look)

    def _light(self, room: Room, hops: int, windows: float) -> None:
        """Add lamps and set the emitters; all other rooms share one dim finish of each kind.

        `windows` is the area of the room's windows in square metres.
        """
        rng = generator(self.seed, self.house.id, room.id, "lamps")
        lamp = "lamp" if hops == 0 else "lamp beyond"
        if hops == 0:
            area = add_lamps(self.geometry, room, lamp, rng)
            light = generator(self.seed, self.house.id, room.id, "light")
            area_m2 = room_polygon(room).area
            plan = (
                self.decor.light(area_m2, windows)
                if self.decor
                else draw_light(light, area_m2, windows)
            )
            self.finishes[SKY[0]] = sky_finish(plan)
            beyond = replace(plan, sky=min(plan.sky, 15.0))
            self.finishes[SKY[1]] = sky_finish(beyond)
            self.finishes[lamp] = lamp_finish(plan, room, area)
            self._plan = plan
        elif (windows == 0.0 or (self.decor and self._plan.sky < 1.0)) and hops < REACH:
            area = add_lamps(self.geometry, room, lamp, rng)
            dim = replace(self._plan, lamps=0.5)
            self.finishes[lamp] = lamp_finish(dim, room, area)


def _is_window(hole: FaceOpening) -> bool:
    return hole.opening.kind == "window"


def surface_finish(material: Material) -> Finish:
    """Return the finish of a material; plaster and carpet are plain diffuse."""
    rough = 1.0 if material.substance in ("plaster", "carpet") else material.roughness
    return Finish(material.albedo, material.size_m, max(rough, 0.08))
