import copy

import numpy as np
import pytest

from plan2scene.errors import InputError
from plan2scene.plans.formats import read_plan
from plan2scene.plans.geometry import room_polygon
from plan2scene.plans.scene_json import house_of_scene
from plan2scene.plans.scene_writer import house_to_scene

AXES = ([0, 1, 0], [0, 0, 1], [1, 0, 0], [0, -1, 0], [0, 0, -1], [-1, 0, 0])


def turned(document, up, scale=1.0):
    """Return a scene with another axis up and another unit."""
    side = np.array([0, 1, 0] if up[0] else [1, 0, 0])
    back = np.array([side, up, np.cross(side, up)]).T / scale
    found = copy.deepcopy(document)
    arch = found["scene"]["arch"]
    found["scene"]["up"] = arch["up"] = up
    arch.update({"version": "arch@1.0.2", "scaleToMeters": scale})
    arch["regions"] = arch.pop("rooms")

    def turn(value):
        deep = isinstance(value[0], list)
        return [turn(item) for item in value] if deep else (back @ value).tolist()

    for element in arch["elements"]:
        for key in ("points", "offset"):
            if key in element:
                element[key] = turn(element[key])
        for key in ("height", "depth", "extra_height"):
            if key in element:
                element[key] /= scale
        for hole in element.get("holes", ()):
            hole["box"] = {k: [v / scale for v in corner] for k, corner in hole["box"].items()}
    return found


def flat():
    from plan_drawing import FLATS

    return read_plan(FLATS[2], "h1")


@pytest.mark.parametrize("up", AXES)
@pytest.mark.parametrize("scale", [1.0, 0.01])
def test_any_axis_may_be_up(up, scale):
    house = flat()
    found = house_of_scene(turned(house_to_scene(house), up, scale), "h1")
    assert [room.types for room in found.rooms] == [room.types for room in house.rooms]
    for one, other in zip(house.rooms, found.rooms, strict=True):
        assert np.allclose(one.rings[0], other.rings[0])
        assert other.height == pytest.approx(one.height)
    for one, other in zip(house.walls, found.walls, strict=True):
        assert np.allclose([one.start, one.end], [other.start, other.end])
        assert [o.id for o in one.openings] == [o.id for o in other.openings]
        assert other.depth == pytest.approx(one.depth)
    assert found.doors == house.doors


def test_a_scene_as_other_programs_fill_it():
    """Ids with bars, regions of any type, no ceilings, materials of each wall."""
    corners = [[0, 0, 0], [4, 0, 0], [4, 3, 0], [0, 3, 0]]
    wall = {"type": "Wall", "roomId": "room|bed", "height": 2.7, "holes": []}
    wall["materials"] = [{"name": "Walldrywall4Tiled", "diffuse": "#888899"}]
    ends = [(corners[k], corners[(k + 1) % 4]) for k in range(4)]
    elements = [wall | {"id": f"wall|bed|{k}", "points": [*ends[k]]} for k in range(4)]
    box = {"min": [1.5, 0], "max": [2.4, 2.1]}
    elements[0]["holes"] = [{"id": "door|0", "type": "Door", "box": box}]
    floor = {"id": "floor|bed", "type": "Floor", "roomId": ["room|bed"], "points": [corners]}
    elements.append(floor)
    region = {"id": "room|bed", "type": "Other", "walls": []}
    arch = {"version": "arch@1.0.2", "up": [0, 0, 1], "elements": elements, "regions": [region]}
    document = {"format": "sceneState", "scene": {"arch": arch, "up": [0, 0, 1], "object": []}}
    house = house_of_scene(document, "h1")
    assert [(room.id, room.types) for room in house.rooms] == [("room_bed", ("Unknown",))]
    assert room_polygon(house.rooms[0]).area == pytest.approx(12)
    assert [(o.id, o.kind) for w in house.walls for o in w.openings] == [("door_0", "door")]
    region["type"] = "living room"
    assert house_of_scene(document, "h1").rooms[0].types == ("Reception",)


@pytest.mark.parametrize("up", [[0, 1, 1], [0, 0.5, 0], "y", [0, 1], ["a", 0, 1], {"x": 1}])
def test_no_axis(up):
    document = house_to_scene(flat())
    document["scene"]["up"] = up
    with pytest.raises(InputError, match="up along an axis"):
        house_of_scene(document, "h1")
