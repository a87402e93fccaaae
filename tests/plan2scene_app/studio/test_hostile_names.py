import csv
import io
import json

import pytest
from browser import chromium
from index_page import index_page

from plan2scene.house import House, Level, Opening, Room, Wall
from plan2scene.mesh.glb import write_glb
from plan2scene_app.doubts.page import DoubtFiles, write_doubts
from plan2scene_app.editor.editor_page import editor_page
from plan2scene_app.studio.projects import EXTRA, PLAN
from plan2scene_app.viewer.viewer_page import build_viewer

NAMES = [
    "<script>window.ran=1</script>",
    "</script></style></title><script>window.ran=1</script>",
    "\"'><img src=x onerror=window.ran=1 alt=`",
    "javascript:window.ran=1",
    "${window.ran=1} $title &lt;b&gt; {{house}}",
    "\u202egpj.exe",
    "a" * 300,
]
RING = ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0))


def hostile_house(name):
    door = Opening(name, "door", 1.0, 2.0, 0.0, 2.0)
    walls = tuple(
        Wall(f"{name}{k}", (name,), RING[k], RING[(k + 1) % 4], 2.5, openings=(door,) * (k == 0))
        for k in range(4)
    )
    room = Room(name, (name,), (RING,), 2.5, name)
    return House(name, (room,), walls, levels=(Level(name, name, 0.0, 2.5),))


def hostile_state(name):
    level = {"id": name, "name": name, "elevation": 0, "height": 2.5}
    room = {"id": name, "types": [name], "polygon": RING, "level": name}
    door = {"id": name, "kind": "door", "from": [1, 0], "to": [2, 0], "level": name}
    plan = {"format": "plan2scene-plan", "version": 1, "levels": [level], "rooms": [room]}
    return {"plan": plan | {"openings": [door]}, "photos": [{"name": name, "rooms": [name]}]}


def editor(folder, name):
    start = hostile_state(name) | {"house": name, "notes": [name]}
    (folder / "editor.html").write_text(editor_page(start), encoding="utf-8")
    return folder / "editor.html"


def viewer(folder, name):
    write_glb(hostile_house(name), {}, folder / "house.glb")
    surfaces = {f"{name}/floor": {"photo": name, "crop": name}}
    surfaces |= {f"{name}/wall": {"confidence": 0.5, "source": name}}
    facts = {"surfaces": surfaces, "photos": [{"name": name, "number": 1}]}
    build_viewer(folder / "house.glb", folder / "viewer.html", house_id=name, facts=facts)
    return folder / "viewer.html"


def doubts(folder, name):
    with (folder / "photos.csv").open("w", newline="") as file:
        rows = [
            ["room_id", "photo", "probability", "of_kind"],
            [name, name, 0.5, 0.5],
            ["", f"other {name}", "", ""],
        ]
        csv.writer(file).writerows(rows)
    (folder / "doubts.txt").write_text(name)
    files = DoubtFiles(folder / "photos.csv", doubts=folder / "doubts.txt")
    write_doubts(folder / "doubts.html", folder, files, house=hostile_house(name))
    return folder / "doubts.html"


def index(folder, name):
    house = House("h", (Room("r", ("Bedroom",), (RING,), 2.5),), ())
    table = io.StringIO()
    csv.writer(table).writerows([[name], [name]])
    return index_page(folder, house, table.getvalue(), name, name)


@pytest.fixture(scope="module")
def page():
    """Yield a page whose content policies are off: what is escaped alone keeps it safe."""
    with chromium("--enable-unsafe-swiftshader") as browser:
        yield browser.new_context(bypass_csp=True).new_page()


@pytest.fixture
def asked(page):
    """Yield what the page asks for; a fault of its program or a script that ran fails the test."""
    urls, faults = [], []
    page.on("request", lambda request: urls.append(request.url))
    page.on("pageerror", lambda error: faults.append(str(error)))
    yield urls
    assert faults == []


def check(page, name):
    """Nothing of a name became a script or an element; it is there to be read."""
    page.wait_for_timeout(50)
    assert page.evaluate("window.ran") is None, name
    assert page.locator("[href^=javascript], [src=x], [onerror]").count() == 0, name
    assert name.split("\u202e")[-1][:20] in page.locator("html").inner_text()


@pytest.mark.parametrize("make", [editor, viewer, doubts, index])
def test_written_pages(page, asked, make, tmp_path):
    for k, name in enumerate(NAMES[1:4] if make is viewer else NAMES):
        (tmp_path / str(k)).mkdir()
        page.goto(make(tmp_path / str(k), name).as_uri())
        check(page, name)
    home = tmp_path.as_uri()
    assert [url for url in asked if not url.startswith((home, "data:", "blob:"))] == []


def test_the_studio(page, asked, studio):
    for name in NAMES[1:6:2]:
        studio.new_home(page, name)
        for file, value in ((PLAN, hostile_state(name)["plan"]), (EXTRA, {"photos": [name]})):
            (studio.home_of(page) / file).write_text(json.dumps(value))
        page.goto(page.url)
        page.wait_for_selector("body[data-ready]")
        check(page, name)
    assert [url for url in asked if not url.startswith((studio.url, "data:", "blob:"))] == []
