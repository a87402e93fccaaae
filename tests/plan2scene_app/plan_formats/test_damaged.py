"""Any damage to a file of another program is one clear line, or a house."""

import copy
import json
import random

import pytest
from damage import VALUES, places

from plan2scene.errors import InputError
from plan2scene.plans.formats import read_plan
from plan2scene.plans.validate import validate_house

TEXTS = [b"0", b"-1", b"1e308", b"nan", b"", b"\xff\xfe", b"<", b"'/>", b"99999999", b"{", b"\n"]


def read(path, outcomes):
    try:
        validate_house(read_plan(path, "h1", 0.5))
        outcomes["house"] += 1
    except InputError as error:
        assert str(error).startswith((f"file {path}, house h1", "house h1"))
        assert "\n" not in str(error)
        outcomes["fault"] += 1


def roomplan():
    """Two rooms of a scan, with a door and objects."""
    plane = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 2, 1, 0, 1]
    flat = [1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1]
    ring = [[0, 0, 0], [4, 0, 0], [4, 3, 0], [0, 3, 0]]
    wall = {"dimensions": [4, 2.5, 0], "transform": plane, "story": 0}
    floor = {"dimensions": [4, 3, 0], "transform": flat, "polygonCorners": ring}
    section = {"label": "kitchen", "center": [1, 0, 1]}
    room = {"walls": [wall], "doors": [wall], "floors": [floor], "sections": [section]}
    sofa = {"category": {"sofa": {}}, **wall}
    return {"rooms": [room, {**copy.deepcopy(room), "objects": [sofa], "story": 1}]}


def zind():
    """A floor of a cleaned plan and one of a panorama."""
    ring = [[0, 0], [4, 0], [4, 3], [0, 3]]
    room = {"vertices": ring, "pins": [{"label": "bath"}], "doors": [[1, 0], [2, 0]]}
    place = {"rotation": 10, "scale": 1, "translation": [1, 1]}
    layout = {"vertices": ring, "windows": [[1, 0], [2, 0], [-1, 1]]}
    pano = {"is_primary": True, "label": "hall", "ceiling_height": 2, "layout_raw": layout}
    panos = {"p": {"q": {**pano, "floor_plan_transformation": place}}}
    return {
        "scale_meters_per_coordinate": {"f1": 1.0, "f2": 1.5},
        "redraw": {"f1": {"r": room}},
        "merger": {"f2": {"c": panos}},
    }


@pytest.mark.parametrize("make", [roomplan, zind])
def test_damaged_json(tmp_path, make):
    path, generator = tmp_path / "plan.json", random.Random(0)
    outcomes = {"house": 0, "fault": 0}
    for _ in range(200):
        document = make()
        container, key = generator.choice(places(document))
        if generator.random() < 0.3:
            del container[key]
        else:
            container[key] = copy.deepcopy(generator.choice(VALUES))
        path.write_text(json.dumps(document))
        read(path, outcomes)
    assert min(outcomes.values()) > 20


def sweet_home(path):
    import zipfile

    text = """<home wallHeight='250'><level id='a' height='250'/><level id='b'/>
    <wall level='a' xStart='0' yStart='0' xEnd='400' yEnd='0' thickness='10' arcExtent='0.5'/>
    <room level='a' name='Bad'><point x='0' y='0'/><point x='400' y='0'/>
    <point x='0' y='300'/></room>
    <doorOrWindow level='a' name='Window' x='90' y='0' width='90' depth='10' height='100'
     elevation='90' wallLeft='0.1' wallWidth='0.8'/>
    <light x='1' y='2' width='3' depth='4'/></home>"""

    def write(content):
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("Home.xml", content)

    return text.encode(), write


def svg(path):
    text = """<svg viewBox='0 0 9 9'><g class='Floor' transform='matrix(1,0,0,1,5,5) scale(2)'>
    <g class='Space Bath'><polygon points='0,0 100,0 100,100 0,100'/><text>9 m2</text></g>
    <g class='Wall'><polygon points='0,0 100,0 100,4 0,4'/></g>
    <g class='Door'><polygon points='20,0 50,0 50,4 20,4'/></g></g></svg>"""
    return text.encode(), path.write_bytes


def dxf(path):
    ezdxf = pytest.importorskip("ezdxf")
    doc = ezdxf.new("R2000")
    doc.header["$INSUNITS"] = 6
    space = doc.modelspace()
    space.add_lwpolyline([(0, 0), (4, 0), (4, 3)], close=True, dxfattribs={"layer": "ROOM"})
    space.add_line((0, 0), (4, 0), dxfattribs={"layer": "WALL"})
    doc.blocks.new("DOOR").add_arc((0, 0), 0.9, 0, 90)
    space.add_blockref("DOOR", (1, 0))
    doc.saveas(path)
    return path.read_bytes(), path.write_bytes


@pytest.mark.parametrize("make", [sweet_home, svg, dxf])
def test_damaged_bytes(tmp_path, make):
    path, generator = tmp_path / "plan.any", random.Random(1)
    text, write = make(path)
    outcomes = {"house": 0, "fault": 0}
    for _ in range(25 if make is dxf else 150):
        place = generator.randrange(len(text))
        length = generator.choice([0, 1, 2, 5, 20])
        write(text[:place] + generator.choice(TEXTS) + text[place + length :])
        read(path, outcomes)
    write(text)
    assert read_plan(path, "h1", 0.5).rooms
    assert outcomes["fault"] > 0
