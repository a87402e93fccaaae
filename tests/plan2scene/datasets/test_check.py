from dataclasses import replace

import numpy as np
import pytest

from plan2scene.datasets.assignments import PhotoAssignment, read_assignment, rooms_of_photos
from plan2scene.datasets.import_plan import import_plan
from plan2scene.errors import InputError
from plan2scene.house import House, Room
from plan2scene.images import png_bytes
from plan2scene.plans.geometry import walls_of_rooms
from plan2scene.plans.scene_writer import write_scene_json
from plan2scene_app.check import check_dataset
from plan2scene_app.workflow.drops import read_unobserved
from plan2scene_app.workflow.house_table import TableRow, read_table, table_of_lists

HEADER = "house\tsplit\tplan\tassignment\tphotos\n"


def small_house():
    rooms = (Room("a", ("Bedroom",), (((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)),), 2.5),)
    return House("h1", rooms, tuple(walls_of_rooms(rooms)))


def table(tmp_path, text, name="h1.photoroom.csv"):
    path = tmp_path / name
    path.write_text(text)
    return path


@pytest.fixture
def dataset(tmp_path):
    for folder in ("archs_no_objects/test", "photo_assignments/test", "photos", "data_lists"):
        (tmp_path / folder).mkdir(parents=True)
    write_scene_json(small_house(), tmp_path / "archs_no_objects/test/h1.scene.json")
    table(tmp_path / "photo_assignments/test", "room_id,photo\na,one.png\n")
    (tmp_path / "photos/one.png").write_bytes(png_bytes(np.zeros((4, 6, 3), np.uint8)))
    (tmp_path / "data_lists/test.txt").write_text("h1\n")
    (tmp_path / "unobserved_photos.json").write_text('{"0.0": [], "0.6": ["one.png"]}')
    return tmp_path


@pytest.mark.parametrize(
    ("text", "room"),
    [
        ("room_id,photo\na,one.jpg\na,two.jpg\n", "a"),
        ("roomId;Photo\r\na;one.jpg\r\nA;two.jpg\r\n", "a"),
        ("\ufeffphoto,room_id\none.jpg,a\ntwo.jpg,a\n", "a"),
        ("index,room_id, photo \n0,a, one.jpg\n\n1,a,two.jpg\n2,a,one.jpg\n", "a"),
        ("photo\none.jpg\ntwo.jpg\n", ""),
        ("photo,room_id\none.jpg\ntwo.jpg\n", ""),
    ],
)
def test_assignment_headers_and_tables_without_rooms(tmp_path, text, room):
    path, names = table(tmp_path, text), ("one.jpg", "two.jpg")
    assert read_assignment(path, small_house()) == tuple(PhotoAssignment(room, n) for n in names)
    assert rooms_of_photos(path, small_house()) == dict.fromkeys(names, [room] if room else [])


def test_rooms_of_photos(tmp_path, caplog):
    path = table(tmp_path, "room_id,photo\nb,x.jpg\na,y.jpg\na,x.jpg\nb,x.jpg\n")
    house = small_house()
    both = replace(house, rooms=(*house.rooms, replace(house.rooms[0], id="b")))
    assert rooms_of_photos(path, both) == {"x.jpg": ["b", "a"], "y.jpg": ["a"]}
    assert rooms_of_photos(path, house, traced=True) == {"x.jpg": ["a"], "y.jpg": ["a"]}
    read_assignment(path, house, traced=True)
    assert "found 'b' for photo x.jpg; its room is looked for" in caplog.text
    assert rooms_of_photos(None, house) == {}


def test_import_stops_at_a_bad_table(tmp_path, caplog):
    write_scene_json(small_house(), tmp_path / "plan.json")
    bad = table(tmp_path, "room_id,photo\ncellar,one.jpg\n")
    with pytest.raises(InputError, match="room cellar"):
        import_plan(tmp_path / "plan.json", tmp_path / "o.json", house_id="h1", assignment=bad)
    assert not (tmp_path / "o.json").exists()
    empty = table(tmp_path, "")
    import_plan(tmp_path / "plan.json", tmp_path / "o.json", house_id="h1", assignment=empty)
    assert f"file {empty}, house h1: expected at least one photo, found none" in caplog.messages
    assert (tmp_path / "o.json").is_file()
    given = {"assignment": table(tmp_path, "room_id,photo\na,gone.jpg\n"), "photos_dir": tmp_path}
    import_plan(tmp_path / "plan.json", tmp_path / "o.json", house_id="h1", **given)
    assert caplog.messages[-1].endswith(f"photo gone.jpg in {tmp_path}, found no such file")


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("room_id,photo\ncellar,one.jpg\n", "house h1, room cellar: expected a room of the plan"),
        ("room_id,photo\na,../one.jpg\n", "house h1: expected a plain file name without '..'"),
        ("room_id,photo\na,one.jpg\na,one.png\n", "house h1: expected photo names that differ"),
        ("room,photo\na,one.jpg\n", "house h1: expected columns room_id and photo"),
        ("room_id,photo\na\n", "house h1: expected a photo in each row, found row 2: a"),
        ("", "expected the columns house, split, plan"),
        ("house,split\nh1,test\n", "expected the columns house, split, plan"),
        (HEADER.strip() + "\tnote\n", "photos, note"),
        (HEADER, "expected at least one house, found none"),
        (HEADER + "h1\ttest\tp\t\t\nh1\ttest\tp\t\t\n", "house h1: expected each house once"),
        (HEADER + "h1\tdev\tp\t\t\n", "house h1: expected a split (train, val, test), found dev"),
        (HEADER + "../h\ttest\tp\t\t\n", "expected a house name of letters"),
        (HEADER + "h1\ttest\t../p\t\t\n", "house h1: expected a plain file name"),
        (HEADER + "h1\ttest\tp\t/t\t\n", "house h1: expected a plain file name"),
        (HEADER + "h1\ttest\t\t\t\n", "house h1: expected a plain file name"),
        (HEADER + "h1\ttest\tp\t\t\tmore\n", "expected 5 cells in each row, found 6 in row 2"),
    ],
)
def test_line_of_a_bad_table(tmp_path, text, line):
    path = table(tmp_path, text)
    with pytest.raises(InputError) as caught:
        read_assignment(path, small_house()) if text.startswith("room") else read_table(path)
    assert str(caught.value).startswith(f"file {path}") and line in str(caught.value)


def test_the_table_of_data_lists_and_of_an_incomplete_data_set(dataset):
    found = table_of_lists(dataset)
    files = ("archs_no_objects/test/h1.scene.json", "photo_assignments/test/h1.photoroom.csv")
    assert found.houses == {"h1": TableRow("h1", "test", *files, ("one.png",))}
    assert found.warnings == ()
    (dataset / "data_lists/val.txt").write_text("h2\nh3\n")
    (dataset / "full_archs/val").mkdir(parents=True)
    write_scene_json(small_house(), dataset / "full_archs/val/h3.scene.json")
    table(dataset / "photo_assignments/test", "roomId,photo\na,../one.png\n")
    made = table_of_lists(dataset)
    assert [line.split(", house ")[1].split(":")[0] for line in made.warnings] == ["h2", "h1"]
    rows = made.houses
    assert list(rows) == ["h2", "h3", "h1"]
    assert rows["h3"] == TableRow("h3", "val", "full_archs/val/h3.scene.json", "", ())
    assert rows["h1"].photos == ()


def test_unobserved(tmp_path):
    path = tmp_path / "u.json"
    path.write_text('{"0.0": [], "0.60": ["a.jpg"], "1": ["a.jpg", "b.jpg"]}')
    assert read_unobserved(path) == {"0.0": [], "0.6": ["a.jpg"], "1.0": ["a.jpg", "b.jpg"]}
    for text in ("[]", '{"a": []}', '{"2.0": []}', '{"0.0": 3}', '{"0.0": [3]}', '{"nan": []}'):
        path.write_text(text)
        with pytest.raises(InputError, match=r"^file .*u\.json: expected"):
            read_unobserved(path)


def test_every_problem_is_a_line(dataset):
    photos = dataset / "photos"
    (photos / "text.jpg").write_text("no image")
    (photos / "cut.png").write_bytes((photos / "one.png").read_bytes()[:-20])
    table(dataset, HEADER + "h1\ttest\tarchs_no_objects/test/h1.scene.json\t"
          "photo_assignments/test/h1.photoroom.csv\t"
          "one.png|text.jpg|cut.png|../up.jpg|gone.jpg\n"
          "h2\tval\tnone.json\t\t\n", "houses.tsv")  # fmt: skip
    (dataset / "unobserved_photos.json").write_text('{"0.6": ["elsewhere.jpg"]}')
    lines = [str(problem) for problem in check_dataset(dataset)]
    starts = (
        f"error: file {dataset / 'houses.tsv'}, house h1: expected a plain",
        f"warning: file {photos / 'cut.png'}, house h1: expected an image",
        f"warning: file {photos / 'gone.jpg'}, house h1: expected an image, found no such file",
        f"warning: file {photos / 'text.jpg'}, house h1: expected an image (",
        f"error: file {dataset / 'none.json'}, house h2: expected a plan, found no such file",
        "warning: ",
    )
    for line, start in zip(lines, starts, strict=True):
        assert line.startswith(start) and "\n" not in line
    assert lines[0].endswith("found '../up.jpg'")
