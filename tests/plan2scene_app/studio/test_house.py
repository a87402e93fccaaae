import numpy as np
import pytest
import trimesh
from flat_picture import flat_picture

from plan2scene.images import write_png
from plan2scene.plans.formats import read_plan
from plan2scene.plans.geometry import room_polygon


@pytest.fixture
def drawing(open_home, request):
    with open_home(request.node.name) as found:
        yield found


def made_house(drawing, folder):
    page = drawing.page
    page.wait_for_function("() => !house.host.pending")
    page.click("#make")
    page.wait_for_function("() => ['done', 'failed'].includes(house.run.state)", timeout=1000 * 600)
    assert page.evaluate("[house.run.state, house.run.fault]") == ["done", ""]
    assert set(page.locator(".stages li").all_text_contents()) >= {"Plan", "The house in 3D"}
    page.wait_for_selector("iframe")
    with page.expect_download() as download:
        page.get_by_role("link", name="GLB").click()
    download.value.save_as(folder / "house.glb")
    return trimesh.load(folder / "house.glb")


def assert_is_the_plan(scene, house):
    for room in house.rooms:
        area = float(scene.geometry[f"{room.id}/floor"].area)
        assert area == pytest.approx(room_polygon(room).area, rel=0.01)
    corners = np.concatenate([np.array(room.rings[0]) for room in house.rooms])
    extent = (scene.bounds[1] - scene.bounds[0])[[0, 2]]
    np.testing.assert_allclose(extent, np.ptp(corners, axis=0), atol=0.5)


def doors_of(plan):
    return sum(opening["kind"] == "door" for opening in plan["openings"])


def test_a_picture_is_traced_mended_and_made(drawing, studio, tmp_path):
    page = drawing.page
    write_png(tmp_path / "flat.png", flat_picture())
    page.click("#open")
    page.set_input_files("#file-input", tmp_path / "flat.png")
    page.wait_for_function("() => editor.store.plan.rooms.length === 2", timeout=100_000)
    # The scale was a guess: two points may tell it, or that the flat is 8.1 m wide.
    assert page.evaluate("editor.tool.name") == "scale"
    assert page.locator("dialog[open]").count() == 0
    page.get_by_role("button", name="How the plan file is read").click()
    page.get_by_label("Its whole width").fill("8.1")
    page.get_by_role("button", name="Read again").click()
    page.wait_for_function(
        "() => { const rooms = editor.store.plan.rooms;"
        " const x = rooms.flatMap((room) => room.polygon.map((p) => p[0]));"
        " return Math.abs(Math.max(...x) - Math.min(...x) - 8.1) < 0.05; }",
        timeout=100_000,
    )
    low, high = bounds(drawing.plan)
    assert high - low == pytest.approx([8.1, 5.1], abs=0.15)
    # The wall between the rooms is half a metre further to the right, and there is one more door.
    wall = min(np.array(room["polygon"])[:, 0].max() for room in drawing.plan["rooms"])
    drawing.drag((wall, high[1] - 0.5), (wall + 0.5, high[1] - 0.5))
    widths = sorted(np.ptp(np.array(room["polygon"])[:, 0]) for room in drawing.plan["rooms"])
    assert widths == pytest.approx(sorted([wall + 0.5 - low[0], high[0] - wall - 0.5]), abs=0.03)
    doors = doors_of(drawing.plan)
    drawing.press("d")
    drawing.click(high[0], (low[1] + high[1]) / 2)
    assert doors_of(drawing.plan) == doors + 1
    scene = made_house(drawing, tmp_path)
    assert_is_the_plan(scene, read_plan(studio.home_of(page) / "plan.json", "home"))
    assert sum("/door/" in name for name in scene.geometry) == doors + 1


def bounds(plan):
    corners = np.concatenate([np.array(room["polygon"]) for room in plan["rooms"]])
    return corners.min(0), corners.max(0)
