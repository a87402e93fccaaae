"""A room with a door and windows, and the labels that a camera in it sees."""

import numpy as np

from plan2scene.floorplans.geometry import find_doors
from plan2scene.house import House, Opening, Room, Wall
from plan2scene.photos.labels.palette import CEILING, FLOOR, WALL
from plan2scene.photos.locate.likelihood import DOOR, WINDOW

SIZE = (180, 240)
HEIGHT = 2.5
WIDE, DEEP = 5.0, 3.6


def box_house(*, openings=True, wide=WIDE, deep=DEEP):
    """A room of `wide` x `deep` metres with a door and two windows, and a store behind the door."""
    corners = ((0.0, 0.0), (wide, 0.0), (wide, deep), (0.0, deep))
    holes = {
        1: (Opening("door", "door", 0.4, 1.3, 0.0, 2.05),),
        2: (Opening("wide", "window", 0.6, 2.6, 0.8, 2.2),),
        3: (Opening("small", "window", 2.2, 3.0, 1.0, 2.2),),
    }
    walls = [
        Wall(f"w{k}", ("room",), a, b, HEIGHT, openings=holes.get(k, ()) if openings else ())
        for k, (a, b) in enumerate(zip(corners, corners[1:] + corners[:1], strict=True))
    ]
    store = ((wide + 0.1, 0.0), (wide + 2.1, 0.0), (wide + 2.1, 2.0), (wide + 0.1, 2.0))
    rooms = (
        Room("room", ("Bedroom",), (corners,), HEIGHT),
        Room("store", ("Closet",), (store,), HEIGHT),
    )
    return House("h", rooms, tuple(walls), find_doors(rooms, walls))


def rendered(house, camera, eye):
    """Labels of the room from `eye` (x, y, z), by meeting each ray with the box, doors shut."""
    y, x = np.mgrid[0 : SIZE[0], 0 : SIZE[1]]
    rays = camera.rays(np.stack([x, y], axis=-1))
    corners = np.array(house.rooms[0].rings[0])
    low, high = (np.array([p[0], h, p[1]]) for p, h in ((corners[0], 0.0), (corners[2], HEIGHT)))
    with np.errstate(divide="ignore"):
        reach = np.where(rays > 0, (high - eye) / rays, (low - eye) / rays)
    axis = reach.argmin(axis=-1)
    points = eye + rays * reach.min(axis=-1)[..., None]
    labels = np.full(SIZE, WALL, np.uint8)
    labels[(axis == 1) & (rays[..., 1] < 0)] = FLOOR
    labels[(axis == 1) & (rays[..., 1] > 0)] = CEILING
    for wall in house.walls:
        start, end = np.array(wall.start), np.array(wall.end)
        along = (end - start) / wall.length
        offset = points[..., [0, 2]] - start
        at = offset @ along
        on = np.abs(offset @ np.array([along[1], -along[0]])) < 1e-6
        for hole in wall.openings:
            inside = on & (axis != 1) & (at > hole.start) & (at < hole.end)
            inside &= (points[..., 1] > hole.bottom) & (points[..., 1] < hole.top)
            labels[inside] = WINDOW if hole.kind == "window" else DOOR
    return labels
