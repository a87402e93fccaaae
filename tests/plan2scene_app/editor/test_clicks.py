import json
import shutil

import pytest
from browser import pages_and_photos, serious_violations
from PIL import Image
from shapely.geometry import Polygon

from plan2scene.datasets.assignments import read_assignment
from plan2scene.mesh.glb import write_glb
from plan2scene.plans.formats import read_plan
from plan2scene.plans.validate import validate_house


def areas(drawing):
    house = {room["id"]: room["polygon"] for room in drawing.plan["rooms"]}
    return {name: round(Polygon(ring).area, 3) for name, ring in house.items()}


def drop_files(drawing, at, *names):
    x, y = drawing.pixel(*at)
    drawing.page.evaluate(
        """async ([x, y, names]) => {
          const canvas = new OffscreenCanvas(400, 300), data = new DataTransfer();
          canvas.getContext("2d").fillRect(0, 0, 40, 30);
          const blob = await canvas.convertToBlob();
          for (const name of names) data.items.add(new File([blob], name, { type: "image/png" }));
          const options = { clientX: x, clientY: y, dataTransfer: data, cancelable: true };
          editor.view.svg.dispatchEvent(new DragEvent("drop", options));
        }""",
        [x, y, names],
    )


def two_rooms(drawing):
    drawing.two_rooms()
    drawing.press("n")
    drawing.click(1.5, 0)
    drawing.press("v")


def test_two_rooms_from_nothing_to_a_glb(drawing, tmp_path):
    two_rooms(drawing)
    drawing.click(1, 1)
    drawing.page.get_by_role("button", name="Kitchen").click()
    drawing.page.get_by_label("Name").fill("My kitchen")
    drawing.page.get_by_label("Height").fill("250 cm")
    drawing.page.keyboard.press("Enter")
    drop_files(drawing, (4, 2), "bed.png")
    drawing.page.wait_for_function("() => editor.store.state.photos.length === 1")
    drawing.click(4, 2)
    thumb = drawing.page.locator("#panel .photo img")
    assert thumb.evaluate("(image) => image.decode().then(() => image.naturalWidth)") == 240
    downloads = []
    drawing.page.on("download", lambda download: downloads.append(download))
    drawing.press("v", "Control+s")
    drawing.page.wait_for_function("() => !editor.store.unsaved")
    while len(downloads) < 2:
        drawing.page.wait_for_timeout(20)
    for download in downloads:
        download.save_as(tmp_path / download.suggested_filename)
    assert serious_violations(drawing.page.evaluate) == []
    house = read_plan(tmp_path / "plan.json", "home")
    assert validate_house(house) == []
    rooms = {room.id: room for room in house.rooms}
    assert {name: room.types for name, room in rooms.items()} == {
        "My_kitchen": ("Kitchen",),
        "room_2": ("Unknown",),
    }
    assert (rooms["My_kitchen"].name, rooms["My_kitchen"].height) == ("My kitchen", 2.5)
    assert house.heights == ""  # told: photos do not change them
    assert house.adjacency() == (("My_kitchen", "room_2"),)
    assert sorted(o.kind for wall in house.walls for o in wall.openings) == ["door", "window"]
    rows = read_assignment(tmp_path / "photos.csv", house)
    assert [tuple(row) for row in rows] == [("room_2", "bed.png")]
    write_glb(house, {}, tmp_path / "house.glb")
    assert (tmp_path / "house.glb").read_bytes()[:4] == b"glTF"


def test_a_plan_and_photos_dropped_together(drawing):
    drop_files(drawing, (1, 1), "bed.png", "Grundriss.png", "hall.png")
    drawing.page.get_by_role("button", name="Open", exact=True).last.click()
    drawing.page.wait_for_function("() => editor.store.state.photos.length === 2")
    assert drawing.page.evaluate("editor.picture.width") == 400
    assert drawing.photos == [{"name": name, "rooms": []} for name in ("bed.png", "hall.png")]


@pytest.mark.parametrize("packed", [False, True])
def test_the_only_page_among_photos_is_the_plan(drawing, tmp_path, packed):
    pages_and_photos(home := tmp_path / "home", "p07.png")
    (home / "film.mp4").write_bytes(b"film")
    archive = shutil.make_archive(str(home), "zip", tmp_path, "home")
    drawing.page.click("#open")
    drawing.page.set_input_files("#file-input", archive if packed else sorted(home.iterdir()))
    drawing.page.wait_for_function("() => editor.store.state.photos.length === 2")
    assert sorted(photo["name"] for photo in drawing.photos) == ["b.jpg", "floorplan.jpg"]
    drawing.page.get_by_text("1 not added: see Photos.").wait_for()


def test_walls_move_with_both_rooms_and_what_is_in_them(drawing):
    two_rooms(drawing)
    drawing.drag((3, 2.6), (3.5, 2.6))
    assert areas(drawing) == {"room": 10.5, "room_2": 4.5}
    door = next(o for o in drawing.plan["openings"] if o["kind"] == "door")
    assert door["from"][0] == door["to"][0] == 3.5
    drawing.drag((5, 3), (6, 4))  # the corner alone
    assert areas(drawing)["room"] == 10.5 and areas(drawing)["room_2"] == pytest.approx(6.75)
    for _ in range(2):
        drawing.press("Control+z")
    assert areas(drawing) == {"room": 9.0, "room_2": 6.0}
    drawing.press("Control+Shift+z")
    assert areas(drawing) == {"room": 10.5, "room_2": 4.5}


def test_the_keyboard_alone_draws_and_changes_a_room(drawing):
    drawing.page.locator("#drawing").focus()
    drawing.page.keyboard.type("r4.2x3")
    drawing.press("Enter")
    drawing.page.keyboard.type("2 x 3")
    drawing.press("Enter")
    assert areas(drawing) == {"room": 12.6, "room_2": 6.0}
    assert drawing.plan["rooms"][1]["polygon"][0] == [4.2, 0]
    drawing.press("v", "Shift+ArrowRight")
    assert drawing.plan["rooms"][1]["polygon"][0] == [4.7, 0]
    drawing.press("Delete")
    assert list(areas(drawing)) == ["room"]


def test_problems_are_listed_and_lead_to_what_they_are_of(drawing):
    two_rooms(drawing)
    drawing.drag((4, 1), (1.5, 1))
    drawing.page.wait_for_selector("#problems li")
    assert "rooms that don't overlap" in drawing.page.inner_text("#problems")
    drawing.page.click("#problems li button")
    assert drawing.page.evaluate("editor.selection.id") == "room"
    drawing.press("Control+z")
    twice = "[...editor.store.plan.openings, { ...editor.store.plan.openings[0], id: 'door_2' }]"
    drawing.page.evaluate(f"editor.store.changePlan({{ openings: {twice} }})")
    text = "room: expected doors and windows of the wall apart, found door and the door"
    drawing.page.get_by_role("button", name=text).wait_for()
    drawing.page.evaluate("editor.notes = ['hardly sure: door (room_2)']; editor.renderPanel()")
    drawing.page.locator("#problems .note").get_by_role("button", name="door", exact=True).click()
    drawing.page.get_by_role("heading", name="door door").wait_for()
    assert drawing.page.evaluate("[editor.selection.id, editor.notes.length]") == ["door", 1]


def test_a_wall_ends_in_no_door_and_a_divided_room_keeps_its_swing(drawing):
    drawing.two_rooms()
    swing = "document.querySelector('.opening.door .line').getAttribute('d')"
    before = drawing.page.evaluate(swing)
    for z, rooms in ((1.5, 2), (2.5, 3)):
        drawing.press("w")
        drawing.click(5, z)
        drawing.click(3, z)
        assert len(drawing.plan["rooms"]) == rooms
        if rooms == 2:
            assert "would cut door" in drawing.page.inner_text("#status")
        drawing.press("Escape", "Escape")
    assert drawing.page.evaluate(swing) == before
    assert drawing.page.evaluate("editor.problems") == []


def test_photos_that_cannot_be_read_are_named_and_the_others_kept(drawing, tmp_path):
    for name in ("corrupt.jpg", "phone.heic", "good.png"):
        (tmp_path / name).write_bytes(b"no picture")
    Image.new("RGB", (40, 30), "green").save(tmp_path / "good.png")
    drawing.page.evaluate("editor.pickPhotos(null)")
    drawing.page.set_input_files("#file-input", sorted(tmp_path.iterdir()))
    drawing.page.get_by_text("2 not added: see Photos. good.png added").wait_for()
    refused = drawing.page.locator("#panel .fault").all_inner_texts()
    assert [line.split(" is not added: no picture")[0] for line in refused] == [
        "corrupt.jpg",
        "phone.heic",
    ]
    assert "HEIC" in refused[1]
    assert [photo["name"] for photo in drawing.photos] == ["good.png"]


def test_feet_and_the_scale_of_a_picture(drawing, tmp_path):
    picture = tmp_path / "plan.png"
    Image.new("RGB", (400, 300), "white").save(picture)
    drawing.page.evaluate("editor.pickFile('image/*', (file) => editor.openPicture(file))")
    drawing.page.set_input_files("#file-input", picture)
    drawing.page.wait_for_function("() => editor.picture !== null && editor.tool.name === 'scale'")
    place = "editor.store.state.picture"
    before = drawing.page.evaluate(place)["metres_per_pixel"]
    drawing.page.select_option("#feet", "feet")
    drawing.click(0, 1)
    drawing.click(200 * before, 1)
    drawing.page.locator("dialog input").first.fill("20' 6\"")
    drawing.page.get_by_role("button", name="Set the scale").click()
    drawing.page.wait_for_function("() => editor.tool.name === 'room'")
    after = drawing.page.evaluate(place)["metres_per_pixel"]
    assert after * 200 == pytest.approx(20.5 * 0.3048, rel=0.01)
    drawing.page.select_option("#feet", "metres")
    drawing.press("s")
    drawing.click(0, 1)
    drawing.click(3, 1)
    drawing.page.keyboard.type("1180")  # what is typed goes into the dialog
    drawing.press("Enter")
    assert "1180 of what?" in drawing.page.get_by_role("alert").inner_text()
    drawing.page.get_by_role("button", name="1180 cm").click()
    drawing.page.wait_for_function("() => editor.tool.name === 'room'")
    last = drawing.page.evaluate(place)["metres_per_pixel"]
    assert last / after == pytest.approx(11.8 / 3, rel=0.01)


def test_saved_files_open_again(drawing, tmp_path):
    two_rooms(drawing)
    plan = drawing.plan
    (tmp_path / "plan.json").write_text(json.dumps(plan))
    (tmp_path / "photos.csv").write_text(
        'room_id,photo,guess\nroom_2,"a, b.jpg",\nroom,c.jpg,\nroom,d.jpg,room\n'
    )
    drawing.press("Control+z")
    drawing.page.click("#open")
    files = [tmp_path / name for name in ("photos.csv", "plan.json")]
    drawing.page.set_input_files("#file-input", files)
    drawing.page.wait_for_function("() => editor.store.state.photos.length === 3")
    assert drawing.plan == plan
    assert drawing.photos == [
        {"name": "a, b.jpg", "rooms": ["room_2"]},
        {"name": "c.jpg", "rooms": ["room"]},
        {"name": "d.jpg", "rooms": []},
    ]


def test_what_was_not_saved_is_offered_again(drawing):
    drawing.press("r")
    drawing.drag((0, 0), (4, 3))
    drawing.page.wait_for_function("() => localStorage.length === 1")
    drawing.page.on("dialog", lambda dialog: dialog.accept())
    drawing.page.reload()
    drawing.page.get_by_role("button", name="Go on with it").click()
    assert areas(drawing) == {"room": 12.0}
