from dataclasses import replace

import numpy as np
import pytest
from box_room import box_house
from browser import chromium, serious_violations

from plan2scene.datasets.assignments import read_rows
from plan2scene.house import FROM_PHOTOS, USUAL
from plan2scene.images import write_png
from plan2scene.io import write_json
from plan2scene_app.doubts.page import DoubtFiles, PlacedPhoto, doubt_lines, write_doubts
from plan2scene_app.heights.ceilings import with_ceilings


def test_each_photo_is_shown_in_its_room_and_each_doubt_told(tmp_path):
    house = box_house()
    table = tmp_path / "photos.csv"
    table.write_text(
        "room_id,photo,probability,of_kind,guess\nroom,a.png,0.61,0.61,\nroom,b.png,,,\n"
        "store,c.png,0.17,0.4,store\n,<d>.png,,,\nroom,f.png,0.55,0.6,\n"
    )
    cameras = tmp_path / "cameras.json"
    shown = {"a.png": {"room": 0.61, "store": 0.31, "": 0.08}, "c.png": {"store": 0.17}}
    shown["f.png"] = {"room": 0.55, "store": 0.45}
    shot = {"width": 60, "height": 40, "focal_px": 50.0, "cx": 29.5, "cy": 19.5}
    shot["rotation"] = np.eye(3).tolist()
    write_json(cameras, {name: shot | {"rooms": rooms} for name, rooms in shown.items()})
    masks = tmp_path / "masks"
    masks.mkdir()
    write_json(masks / "warnings.json", ["photo e.txt left out: found text"])
    for name in "abc":
        write_png(tmp_path / f"{name}.png", np.full((40, 60, 3), 99, np.uint8))
    page, traced = tmp_path / "doubts.html", tmp_path / "plan.doubts.txt"
    traced.write_text("rooms room, store: no door\n")
    rooms = tuple(replace(r, name="Attic" if r.id == "store" else "") for r in house.rooms)
    house = replace(house, rooms=rooms)
    files = DoubtFiles(table, masks, cameras, doubts=traced)
    assert write_doubts(page, tmp_path, files, house=house) == [
        "plan: rooms room, store: no door",
        "photo e.txt left out: found text",
        "no room is found for <d>.png",
        "room or Attic? 55 to 61% sure: a.png, f.png",
        "Attic? 17% sure, not used: c.png",
        "no photo shows Attic: made like the other rooms",
    ]
    text = page.read_text()
    assert text.count("data:image/jpeg") == 3 and "&lt;d&gt;.png" in text
    assert "<d>.png" not in text
    room, store = text.index('id="room-room"'), text.index('id="room-store"')
    assert room < text.index("b.png <small>as told") < store < text.index('class="doubt">17%')
    assert '<a href="#plan-room">room</a> or <a href="#plan-store">Attic</a>? 55 to 61%' in text
    choice = text[text.index('aria-label="Room of f.png"') :]
    assert choice.index('"room" selected') < choice.index('"store"') < choice.index('"-"')
    assert 'rooms <a href="#plan-room">room</a>, <a href="#plan-store">Attic</a>: no door' in text


def test_rooms_chosen_on_the_page_are_saved_as_a_photo_table(tmp_path):
    table, page = tmp_path / "photos.csv", tmp_path / "doubts.html"
    table.write_text(
        "room_id,photo,probability,of_kind,guess\nroom,a.png,0.61,0.61,\n"
        'store,"b, c.png",0.17,0.4,store\n,d.png,,,\nroom,e.png,0.3,0.3,room\nroom,f.png,,,\n'
    )
    write_doubts(page, tmp_path, DoubtFiles(table), house=box_house())
    with chromium() as browser:
        shown = browser.new_page()
        shown.goto(page.as_uri())
        assert shown.locator("select").count() == 4  # the room of f.png was told
        for name, room in (("a.png", "store"), ("b, c.png", "store"), ("d.png", "-")):
            shown.get_by_label(f"Room of {name}").select_option(room)
        with shown.expect_download() as download:
            shown.click("#save")
        assert download.value.suggested_filename == "photos.csv"
        download.value.save_as(tmp_path / "saved.csv")
        assert serious_violations(shown.evaluate) == []
    rows = [(row.photo, row.room_id) for row in read_rows(tmp_path / "saved.csv")]
    assert rows == [("a.png", "store"), ("b, c.png", "store"), ("e.png", ""), ("f.png", "room")]


def test_the_traced_picture_is_seen_whole(tmp_path):
    """It stood below the plans, in a column that ends with the window: what was cut was blank."""
    table, overlay, page = (tmp_path / name for name in ("photos.csv", "plan.png", "doubts.html"))
    table.write_text("room_id,photo,probability,of_kind,guess\n")
    write_png(overlay, np.full((800, 900, 3), 99, np.uint8))
    write_doubts(page, tmp_path, DoubtFiles(table, overlay=overlay), house=box_house())
    with chromium() as browser:
        shown = browser.new_page(viewport={"width": 1200, "height": 700})
        shown.goto(page.as_uri())
        picture = shown.locator("details img")
        assert picture.evaluate("image => image.naturalWidth") == 900
        picture.scroll_into_view_if_needed()
        box = picture.bounding_box()
        assert box["width"] > 600
        ends = ([box["x"] + 5, box["y"] + 5], [box["x"] + 5, box["y"] + box["height"] - 5])
        at = "([x, y]) => document.elementFromPoint(x, y).tagName"
        assert [shown.evaluate(at, end) for end in ends] == ["IMG", "IMG"]


def test_photos_without_any_place_are_the_first_doubt():
    lost = [PlacedPhoto(name, "", None) for name in ("a.jpg", "b.jpg")]
    assert list(doubt_lines(box_house(), lost, ["photo c left out"], ["the scale is a guess"])) == [
        "no photo finds its place in the plan: the house is made without 2 photos",
        "plan: the scale is a guess",
        "photo c left out",
    ]


@pytest.mark.parametrize(
    ("heights", "why"), [(USUAL, "as usual: no photo shows them"), (FROM_PHOTOS, "as photos show")]
)
def test_heights_that_the_plan_does_not_tell_are_a_doubt(heights, why):
    house = replace(with_ceilings(box_house(), 2.43), heights=heights)
    assert f"the plan tells no heights: ceilings at 2.43 m, {why}" in doubt_lines(house, [], [], [])
