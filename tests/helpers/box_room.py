import numpy as np
from views import camera_looking

from plan2scene.house import House, Opening, Room, Wall
from plan2scene.photos.camera.calibration import canonical
from plan2scene.photos.labels.palette import CEILING, DOOR, FLOOR, WALL, WINDOW
from plan2scene.photos.locate.locate_photos import Shot
from plan2scene.photos.locate.pose import Pose
from plan2scene.plans.geometry import find_doors

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
    top = house.rooms[0].height
    low, high = (np.array([p[0], h, p[1]]) for p, h in ((corners[0], 0.0), (corners[2], top)))
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


#: Headings and eyes of photos that show most of the room.
VIEWS = [(230.0, (0.6, 1.5, 2.9)), (60.0, (4.2, 1.3, 0.7)), (-80.0, (1.4, 1.6, 1.2))]
VIEWS += [(140.0, (4.4, 1.4, 2.8)), (-120.0, (2.5, 1.2, 3.1))]


def shot(house, heading_deg, eye, *, pitch_deg=6.0, fov_deg=78.0, rooms=("room",)):
    """A photo from a known pose: (shot whose camera knows its frame only, true camera)."""
    focal = SIZE[1] / 2 / np.tan(np.radians(fov_deg) / 2)
    true = camera_looking(SIZE, heading_deg=heading_deg, pitch_deg=pitch_deg, focal=focal)
    known = true.with_rotation(canonical(true.matrix))
    return Shot(known, rendered(house, true, np.array(eye)), rooms), true


DOOR_EYE = np.array([1.2, 1.5, 1.2])


def open_door_view():
    """A look at the open door: (house, pose, labels, end of each ray in the room or behind)."""
    house = box_house()
    camera = camera_looking(SIZE, heading_deg=-86.0, pitch_deg=12.0, focal=150.0)
    labels = rendered(house, camera, DOOR_EYE)
    y, x = np.mgrid[0 : SIZE[0], 0 : SIZE[1]]
    rays = camera.rays(np.stack([x, y], axis=-1))
    ends = DOOR_EYE + rays * reach_in(rays, (0.0, 0.0), (WIDE, DEEP))[..., None]
    through = labels == DOOR
    behind = DOOR_EYE + rays * reach_in(rays, (WIDE + 0.1, 0.0), (WIDE + 2.1, 2.0))[..., None]
    ends[through] = behind[through]
    labels[through] = WALL
    labels[through & (ends[..., 1] < 1e-6)] = FLOOR
    labels[through & (ends[..., 1] > HEIGHT - 1e-6)] = CEILING
    return house, Pose("room", tuple(DOOR_EYE.tolist()), camera, 0.9), labels, ends


def reach_in(rays, low, high):
    """Metres along unit rays from `DOOR_EYE` to where they leave a box over a plan rectangle."""
    low, high = np.array([low[0], 0.0, low[1]]), np.array([high[0], HEIGHT, high[1]])
    with np.errstate(divide="ignore"):
        return np.where(rays > 0, (high - DOOR_EYE) / rays, (low - DOOR_EYE) / rays).min(axis=-1)
