import pytest
from places import STOREYS
from viewer_page import ViewerPage

from plan2scene.mesh.glb import write_glb
from plan2scene.plans.formats import read_plan
from plan2scene_app.viewer.viewer_page import build_viewer

STATE = "[eye.feet.x, eye.feet.y, eye.feet.z, eye.room]"


@pytest.fixture(scope="module")
def view(tmp_path_factory):
    folder = tmp_path_factory.mktemp("storeys")
    write_glb(read_plan(STOREYS, "two"), {}, folder / "house.glb")
    build_viewer(folder / "house.glb", folder / "viewer.html", house_id="two")
    with ViewerPage() as browser:
        browser.open(folder / "viewer.html")
        yield browser
        assert browser.complaints == []


def shown(view):
    return set(
        view.run(
            """(() => {
              draw(1);
              const floors = parts.filter((p) => p.extras.kind === "floor" && p.mesh.visible);
              return floors.map((p) => p.extras.room_id);
            })()"""
        )
    )


def test_a_floor_is_chosen_and_its_rooms_are_listed(view):
    view.run('setMode("orbit"); setLevel(null)')
    ground, upper = {"hall", "living", "wc", "kitchen"}, {"landing", "bedroom", "bathroom", "study"}
    assert shown(view) == ground | upper
    names = view.run('[...$("floors").children].map((button) => button.textContent)')
    assert names == ["All", "Ground floor", "Upper floor"]
    view.run('$("floors").children[1].click()')
    assert shown(view) == ground
    assert view.run('[...$("rooms").children].filter((item) => !item.hidden).length') == len(ground)
    view.run('$("floors").children[2].click()')
    assert shown(view) == upper
    view.run('$("floors").children[0].click()')


def test_stairs_are_walked_up_and_down(view):
    view.run('setMode("walk"); eye.feet.set(0.45, 0, 5.3)')
    x, y, z, room = view.run(f"walkBy(0, -3); {STATE}")
    assert room == "hall" and 1.0 < y < 2.5 and 2.2 < z < 2.5  # on the steps
    x, y, z, room = view.run(f"walkBy(0, -1.7); {STATE}")
    assert (y, room) == (pytest.approx(2.8), "landing") and z < 1.0
    # Past the railing there is no way into the well; by the landing there is one into a room.
    x, y, z, _ = view.run(f"walkBy(1.2, 0); walkBy(0, 1.6); walkBy(-1.5, 0); {STATE}")
    assert y == pytest.approx(2.8) and x > 0.9
    _, y, _, room = view.run(f"eye.feet.set(1.6, 2.8, 2.65); walkBy(2, 0); {STATE}")
    assert (y, room) == (pytest.approx(2.8), "bedroom")
    _, y, z, room = view.run(f"eye.feet.set(0.45, 2.8, 0.6); walkBy(0, 4.7); {STATE}")
    assert (y, room) == (0.0, "hall") and z > 4.6


def test_who_stands_below_the_well_sees_upstairs(view):
    look = 'setMode("walk"); eye.feet.set({x}, 0, {z}); eye.pitch = {up}; eye.yaw = {yaw}'
    upstairs = 'draw(1); parts.some((p) => p.extras.level === "upper" && p.mesh.visible)'
    view.run(look.format(x=0.45, z=5.2, up=0.7, yaw="Math.PI"))
    assert view.run(upstairs)
    view.run(look.format(x=3.65, z=4.7, up=0, yaw="Math.PI / 2"))  # at a wall without an opening
    assert not view.run(upstairs) and shown(view) == {"wc"}
