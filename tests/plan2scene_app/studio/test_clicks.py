import json
import sys
import time

import numpy as np
import pytest
from browser import Drawing, pages_and_photos, serious_violations
from PIL import Image
from unscaled_drawings import dxf

from plan2scene.plans.formats import read_plan
from plan2scene_app.finishes import LIBRARY
from plan2scene_app.studio import runs

#: Stands for the workflow, which takes minutes: tells what it tells, makes what the page shows.
TELL = """
import json, sys
def tell(event, **values):
    with open(sys.argv[1] + "/run_events.jsonl", "a") as file:
        file.write(json.dumps({"event": event, **values}) + "\\n")
def end(state):
    # At once, as the workflow does: the studio never reads half a record.
    from pathlib import Path
    record = json.loads(Path(sys.argv[1], "run.json").read_text())
    Path(sys.argv[1], "new.json").write_text(json.dumps(record | dict(state=state)))
    Path(sys.argv[1], "new.json").replace(Path(sys.argv[1], "run.json"))
"""
JOB = """
from pathlib import Path
from PIL import Image
home = Path(sys.argv[1])
tell("planned", jobs=dict(floorplan=1, house=1))
tell("started", rule="floorplan")
tell("finished", rule="floorplan")
tell("started", rule="house")
house = home / "house"
(house / "textures").mkdir(parents=True, exist_ok=True)
(house / "house.glb").write_bytes(b"glTF")
(house / "viewer.html").write_text("<h1>the house</h1>")
Image.new("RGB", (8, 8), "red").save(house / "textures" / "room_floor.png")
tell("finished", rule="house")
end("done")
"""


def job(code):
    return (sys.executable, "-c", TELL + code)


@pytest.fixture
def drawing(open_home, studio, monkeypatch):
    monkeypatch.setattr(runs, "JOB", job(JOB))
    with open_home(f"My home {len(list(studio.root.iterdir()))}") as found:
        yield found


def two_rooms(drawing):
    drawing.two_rooms()
    drawing.page.wait_for_function("() => !house.host.pending")


def add_photo(drawing, tmp_path, room):
    Image.new("RGB", (64, 48), "green").save(tmp_path / "bed.jpg")
    drawing.page.evaluate("(room) => editor.pickPhotos(room)", room)
    drawing.page.set_input_files("#file-input", tmp_path / "bed.jpg")
    drawing.page.wait_for_function("() => editor.store.state.photos.length && !house.host.pending")


def test_from_nothing_to_a_house_and_a_photo_moved(drawing, studio, tmp_path):
    page, home = drawing.page, studio.home_of(drawing.page)
    two_rooms(drawing)
    page.set_viewport_size({"width": 390, "height": 844})
    page.wait_for_function("() => { const at = editor.view.toPixels([5, 3]); return at[0] < 390; }")
    page.set_viewport_size({"width": 1280, "height": 800})
    add_photo(drawing, tmp_path, "room")
    assert page.locator("#status").inner_text() == "bed.jpg in room"
    assert len(read_plan(home / "plan.json", "home").rooms) == 2
    assert (home / "photos.csv").read_text() == "room_id,photo\nroom,bed.jpg\n"
    assert (home / "photos" / "bed.jpg").read_bytes() == (tmp_path / "bed.jpg").read_bytes()
    page.click("#make")
    page.wait_for_function("() => house.run.state === 'done'")
    page.wait_for_selector("iframe")
    assert page.frame_locator("iframe").locator("h1").inner_text() == "the house"
    assert page.locator(".stages .done").all_text_contents() == ["Plan", "The house in 3D"]
    assert page.locator(".stages").is_hidden()  # folded: the house is there
    page.get_by_text("2 of 2 steps done").click()
    assert page.locator(".stages").is_visible()
    page.set_viewport_size({"width": 390, "height": 844})  # a phone shows the house first
    assert page.locator("iframe").bounding_box()["height"] > 400
    page.set_viewport_size({"width": 1280, "height": 800})
    with page.expect_download() as download:
        page.get_by_role("link", name="GLB").click()
    assert download.value.path().read_bytes()[:4] == b"glTF"
    page.get_by_role("button", name="Textures").click()
    assert page.locator(".tiles figcaption").inner_text() == "room floor"
    assert serious_violations(page.evaluate) == []
    page.reload()  # stays with the house
    page.wait_for_selector("iframe, #results .tiles")
    assert page.locator("#run select").first.is_hidden()  # one good default
    page.get_by_text("For researchers").click()
    page.get_by_label("Walls alike in a").select_option("wall")
    page.locator("#start-run").click()
    page.wait_for_function("() => house.run.settings.walls === 'wall'")
    page.wait_for_function("() => house.run.state === 'done'")
    # The photo shows the other room: its table follows, and the page says what that means.
    page.select_option("#run .photo select", "room_2")
    page.locator("#run .chip", has_text="room_2").wait_for()
    page.locator("#run").get_by_label("Remove room from bed.jpg", exact=True).click()
    page.get_by_text("Only what depends on the change").wait_for()
    page.wait_for_function("() => !house.host.pending")
    assert (home / "photos.csv").read_text() == "room_id,photo\nroom_2,bed.jpg\n"


def test_a_conflict_is_told_and_theirs_can_be_taken(drawing, studio):
    page, home = drawing.page, studio.home_of(drawing.page)
    two_rooms(drawing)
    (home / "photos").mkdir(exist_ok=True)
    Image.new("RGB", (8, 8)).save(home / "photos" / "theirs.jpg")
    (home / "photos.csv").write_text("room_id,photo\nroom,theirs.jpg\n")
    drawing.press("Control+z")
    page.get_by_role("button", name="Keep mine").wait_for()
    page.get_by_role("button", name="Take theirs").click()
    page.wait_for_function("() => editor.store.state.photos.length === 1 && !house.host.pending")
    assert all("40" in line for line in drawing.faults)  # how a browser tells a refusal
    drawing.faults.clear()


#: Stands for a workflow that makes a viewer alone: clicks in it choose a surface by its name.
CLICKED = """
from pathlib import Path
home = Path(sys.argv[1])
(home / "house").mkdir(exist_ok=True)
(home / "house" / "viewer.html").write_text(
    "<h1>the house</h1><p>wall</p><p>floor</p><p>trim</p><p>door</p><script>onmessage = (e) =>"
    " (document.querySelector('h1').textContent = e.data.colour); document.body.onclick = (e) =>"
    " parent.postMessage({kind: 'surface', room: e.target.textContent === 'door' ? 'door' :"
    " 'room', surface: e.target.textContent, title: e.target.textContent}, '*')</script>"
)
(home / "house" / "photos.csv").write_text("photo,room_id\\nbed.jpg,room_2")
line = "file /a/plan.json, house h, room room: expected a, found b"
tell("finished", rule="house", warnings=[line])
end("done")
"""


def test_a_house_asked_for_twice_at_once_is_made_once(drawing, monkeypatch):
    page, begin, begun = drawing.page, runs.start, []

    def slowly(*arguments):
        begun.append(arguments)
        time.sleep(1.5)  # as on a machine that has much to do
        begin(*arguments)

    monkeypatch.setattr(runs, "start", slowly)
    two_rooms(drawing)
    page.evaluate("() => { house.start(); house.start(); house.makeAgain(); }")
    page.wait_for_function("() => house.run.state === 'done'")
    assert len(begun) == 1


def test_surfaces_are_clicked_and_set_by_hand(drawing, studio, tmp_path, monkeypatch):
    page, table = drawing.page, studio.home_of(drawing.page) / "plan.finishes.csv"
    monkeypatch.setattr(runs, "JOB", job(CLICKED))
    two_rooms(drawing)
    add_photo(drawing, tmp_path, "room")
    page.click("#make")
    page.wait_for_function("() => house.run.state === 'done'")
    assert page.evaluate("house.found.get('bed.jpg')") == "room_2"
    page.get_by_text("One thing to know").click()
    assert page.locator("#run details p").inner_text() == "room: expected a, found b"
    house, hand = page.frame_locator("iframe"), page.locator("#finishes")

    def choose(surface):
        for _ in range(50):  # a click is lost while the house is shown anew
            house.locator("p", has_text=surface).click()
            page.wait_for_timeout(200)
            if hand.locator("b", has_text=surface).is_visible():
                return
        raise AssertionError(surface)

    hand.get_by_label("Surface").select_option("room_2, ceiling")  # by keys alone
    hand.locator("b", has_text="room_2, ceiling").wait_for()
    choose("floor")
    for what in LIBRARY:
        page.get_by_label("Material", exact=False).select_option(what)
        hand.locator(".set").get_by_text(f"room, floor: {what}", exact=True).wait_for()
        assert table.read_text() == f"room,surface,what\nroom,floor,{what}\n"
    page.get_by_text("As in a photo").click()
    hand.get_by_role("button", name="bed.jpg").click()
    hand.get_by_text("room, floor: as in photo bed.jpg").wait_for()
    choose("wall")
    page.get_by_label("Same as in", exact=False).select_option("same:room_2")
    hand.get_by_text("room, wall: as in room_2").wait_for()
    for surface in ("trim", "door"):
        choose(surface)
        assert hand.locator("select, .picks").count() == 1  # of surfaces: they have a colour alone
        hand.get_by_label(f"Colour of {surface}").fill("#204060")
        house.get_by_text("#204060").wait_for()
    hand.get_by_text("room, skirting and frames: #204060").wait_for()
    hand.get_by_text("room \u2013 room_2, door: #204060").wait_for()
    Image.new("RGB", (60, 40), (200, 30, 20)).save(tmp_path / "swatch.png")
    hand.get_by_role("button", name="From a picture").click()
    page.set_input_files("#file-input", tmp_path / "swatch.png")
    page.locator("canvas.pick").click()
    page.get_by_role("button", name="Take it").click()
    hand.get_by_text("room \u2013 room_2, door: #c81e14").wait_for()
    rows = ["door,door,#c81e14", "room,floor,photo:bed.jpg", "room,trim,#204060"]
    assert table.read_text().splitlines() == ["room,surface,what", *rows, "room,wall,same:room_2"]
    # A renamed room keeps what is set, and what is as in it.
    page.evaluate("editor.select({kind: 'room', id: 'room_2'})")
    page.get_by_role("tab", name="Plan and photos").click()
    page.get_by_label("Name").fill("Hall")
    page.get_by_label("Name").press("Enter")
    page.wait_for_function("() => house.finishes.of('room', 'wall') === 'same:Hall'")
    page.get_by_role("tab", name="House").click()
    # It is made again by itself; until then the viewer shows it, as far as it is a colour.
    page.wait_for_function("() => house.run.settings.finishes === house.run.finishes")
    page.wait_for_function("() => house.run.state === 'done'")
    choose("wall")
    hand.get_by_role("button", name="White").click()
    hand.get_by_text("room, wall: white").wait_for()
    hand.get_by_role("button", name="Undo").click()
    hand.get_by_text("room, wall: as in Hall").wait_for()
    page.get_by_label("room wall as found").click()
    hand.get_by_text("room, wall:").wait_for(state="detached")
    assert table.read_text().splitlines() == ["room,surface,what", *rows]
    said = studio.ask("PUT", f"p/{table.parent.name}/finishes", {"rows": [["a", "roof", "white"]]})
    assert said[0] == 400 and "a surface of floor, wall, ceiling, door" in said[1]["error"]


def test_a_drawing_without_scale_and_layers_is_asked_for_them(drawing, studio, tmp_path):
    pytest.importorskip("ezdxf")
    page, file = drawing.page, tmp_path / "flat.dxf"
    file.write_bytes(dxf())
    page.click("#open")
    page.set_input_files("#file-input", file)
    dialog = page.locator("dialog[open]")
    assert "$INSUNITS" in dialog.get_by_role("alert").inner_text()
    dialog.get_by_label("walls").focus()
    dialog.get_by_role("button", name="W1").click()
    assert dialog.get_by_label("walls").input_value() == "W1"
    dialog.get_by_label("Metres a unit").fill("12 inches")
    dialog.get_by_role("button", name="Read again").click()
    dialog.get_by_text("found '12 inches'").wait_for()
    dialog.get_by_label("Metres a unit").fill("0,001")
    dialog.get_by_role("button", name="Read again").click()
    page.wait_for_function("() => editor.store.plan.rooms.length === 2 && !house.host.pending")
    assert len(read_plan(studio.home_of(drawing.page) / "plan.json", "home").rooms) == 2
    page.reload()
    page.wait_for_selector("body[data-ready]")
    page.get_by_role("button", name="How the plan file is read").click()
    dialog.get_by_label("or its whole width").fill("12 m")
    dialog.get_by_role("button", name="Read again").click()
    far = "(r) => r.polygon.some(([x]) => Math.abs(x) > 11)"
    page.wait_for_function(f"() => editor.store.plan.rooms.some({far}) && !house.host.pending")
    assert all("400" in line for line in drawing.faults)  # how a browser tells a refusal
    drawing.faults.clear()


#: Stands for a workflow whose first stage never ends, and for one whose first stage fails.
STUCK = """
import time
tell("planned", jobs=dict(floorplan=1, house=1))
tell("started", rule="floorplan")
time.sleep(60)
"""
FAILING = """
tell("planned", jobs=dict(masks=1))
tell("started", rule="masks")
fault = "file photos/a.jpg, house home: expected a JPEG, found text"
tell("failed", rule="masks", message=fault)
end("failed")
"""


def test_a_run_is_cancelled_fails_with_a_line_and_goes_on(drawing, monkeypatch):
    page, whole = drawing.page, runs.JOB
    two_rooms(drawing)
    monkeypatch.setattr(runs, "JOB", job(STUCK))
    page.click("#make")
    page.locator(".stages .running", has_text="Plan").wait_for()
    assert page.locator("#badge").inner_text() == "0/2"
    page.click("#cancel")
    page.get_by_text("What is made stays; a run goes on from there.").wait_for()
    monkeypatch.setattr(runs, "JOB", job(FAILING))
    page.locator("#start-run", has_text="Go on").click()
    line = page.locator("#run .fault")
    line.wait_for()
    assert line.inner_text() == "file photos/a.jpg, house home: expected a JPEG, found text"
    assert page.locator(".stages .failed").all_text_contents() == ["What the photos show"]
    monkeypatch.setattr(runs, "JOB", whole)
    page.locator("#start-run", has_text="Try again").click()
    page.wait_for_function("() => house.run.state === 'done'")
    assert page.locator(".stages .done").all_text_contents() == ["Plan", "The house in 3D"]


def test_in_a_dropped_folder_the_plans_of_the_storeys_are_found(drawing, studio, tmp_path):
    page, home = drawing.page, studio.home_of(drawing.page)
    pages_and_photos(tmp_path, "first floor.png", "ground.png")
    (tmp_path / "hall").mkdir()
    (tmp_path / "b.jpg").rename(tmp_path / "hall" / "b.jpg")
    (x, y), session = drawing.pixel(1, 1), page.context.new_cdp_session(page)
    dragged = {"items": [], "files": [str(tmp_path)], "dragOperationsMask": 1}
    for kind in ("dragEnter", "drop"):
        session.send("Input.dispatchDragEvent", {"type": kind, "x": x, "y": y, "data": dragged})
    page.get_by_role("heading", name="Which pictures are the plan?").wait_for()
    ticked = page.locator("dialog label:has(input:checked)").all_inner_texts()
    assert [name.strip() for name in ticked] == ["first floor.png", "ground.png"]
    page.get_by_role("dialog").get_by_role("button", name="Open").click()
    page.wait_for_function("() => editor.store.state.photos.length === 2 && !house.host.pending")
    assert [photo["name"] for photo in drawing.photos] == ["floorplan.jpg", "hall_b.jpg"]
    rows = np.asarray(Image.open(home / "plan_source").convert("L")).min(axis=1) < 128
    first, second, third = np.flatnonzero(np.diff(rows.astype(int)) == 1)
    assert second - first > third - second  # the ground floor, with two lines, is the first


def test_a_brochure_gives_its_plan_and_its_photos(drawing, studio, tmp_path):
    page, home = drawing.page, studio.home_of(drawing.page)
    noise = np.random.default_rng(0).integers(0, 255, (40, 60, 3), np.uint8)
    photo, sheet = (Image.new("RGB", (600, 400), "white") for _ in range(2))
    photo.paste(Image.fromarray(noise).resize((600, 400)))
    sheet.paste("black", (40, 40, 460, 48))
    sheet.save(tmp_path / "brochure.pdf", save_all=True, append_images=[photo], resolution=72)
    page.click("#open")
    page.set_input_files("#file-input", tmp_path / "brochure.pdf")
    page.wait_for_function("() => editor.store.state.photos.length === 1 && !house.host.pending")
    assert page.evaluate("editor.picture !== null")
    assert drawing.photos == [{"name": "page02_1.jpg", "rooms": []}]
    assert Image.open(home / "photos" / "page02_1.jpg").size == (600, 400)
    page.evaluate("editor.notes = ['a doubt', 'another']; editor.changed()")
    page.get_by_role("button", name="Seen: another").click()
    page.wait_for_function("() => !house.host.pending")
    page.reload()
    page.get_by_role("button", name="Seen: a doubt").wait_for()
    assert page.evaluate("editor.notes") == ["a doubt"]


def test_two_points_on_a_picture_are_kept_as_its_scale(drawing, studio, tmp_path):
    page, home = drawing.page, studio.home_of(drawing.page)
    Image.new("RGB", (400, 300), "white").save(tmp_path / "plan.png")
    page.click("#open")
    page.set_input_files("#file-input", tmp_path / "plan.png")
    page.wait_for_function("() => editor.picture !== null && editor.tool.name === 'scale'")
    metres = page.evaluate("editor.store.state.picture.metres_per_pixel")
    drawing.click(0, 1)
    drawing.click(0, 1)  # twice on one point says nothing
    assert page.locator("dialog[open]").count() == 0
    drawing.click(200 * metres, 1)
    page.locator("dialog input").first.fill("5 m")
    page.get_by_role("button", name="Set the scale").click()
    page.wait_for_function("() => editor.tool.name === 'room' && !house.host.pending")
    kept = json.loads((home / "plan_source.json").read_text())
    assert kept["two_points"] == pytest.approx(5 / 200, rel=0.01)
    drawing.press("Control+z")
    page.wait_for_function("() => !house.host.pending")
    assert json.loads((home / "plan_source.json").read_text())["two_points"] is None


def test_two_tabs_and_a_reload_lose_nothing(drawing, studio, context):
    two_rooms(drawing)
    other = Drawing(context.new_page())
    other.page.goto(drawing.page.url)
    assert other.plan == drawing.plan
    other.press("r")
    other.drag((0, 3), (5, 5))
    other.page.wait_for_function("() => !house.host.pending")
    drawing.page.bring_to_front()
    drawing.page.wait_for_function("() => editor.store.plan.rooms.length === 3")
    assert drawing.plan == other.plan
    drawing.page.reload()
    drawing.page.wait_for_selector("body[data-ready]")
    assert drawing.plan == other.plan
    other.page.close()
    assert other.faults == []
