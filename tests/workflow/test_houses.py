"""Good, odd and bad houses of one data set, made together: each fault is one clear line.

Every case is a house of its own; all are run with ``--keep-going``: the odd one, of unknown height,
to its crops, one whose plan and method another package reads and has to its textures, the others to
their plans.
"""

import json
import shutil
import struct
import zlib
from pathlib import Path

import pytest
from clones import DEMO, demo_rows, make_clone, photos_of, write_table
from flat_picture import flat_picture
from PIL import Image

from plan2scene.house import FROM_PHOTOS, USUAL
from plan2scene.images import read_image
from plan2scene.io import read_parquet
from plan2scene.plans.formats import read_plan
from plan2scene.plans.scene_json import read_scene_json
from plan2scene_app.plan_writer import house_to_plan

GOOD = demo_rows()[0] if (DEMO / "houses.tsv").is_file() else {}
HOUSES = Path("results/tiny/houses")
#: A photo of the odd house that must be left out: a word of its line.
BAD = {
    "bomb.png": "found 3600000000",
    "cut.jpg": "decodes",
    "empty.jpg": "an empty file",
    "gone.jpg": "no such file",
    "phone.jpg": "damaged HEIC",
    "point.png": "found 1x1",
    "strip.png": "found 20000x10",
    "text.jpg": "found text",
}


def odd_copies(photos):
    """Replace photos by the same pictures: CMYK, turned by EXIF, a palette, grey with 16 bits."""
    first, second, third, fourth = photos[:4]
    Image.open(first).convert("CMYK").save(first, format="JPEG", quality=92)
    exif = Image.Exif()
    exif[0x0112] = 6
    upright = Image.open(second).convert("RGB")
    upright.transpose(Image.Transpose.ROTATE_90).save(second, "JPEG", quality=92, exif=exif)
    Image.open(third).convert("P", palette=Image.Palette.ADAPTIVE).save(third, format="PNG")
    grey = Image.open(fourth).convert("L").convert("I").point(lambda value: value * 257)
    grey.convert("I;16").save(fourth, format="PNG")


def damaged(folder, good):
    head = struct.pack(">IIBBBBB", 60000, 60000, 8, 2, 0, 0, 0)
    chunk = struct.pack(">I", 13) + b"IHDR" + head + struct.pack(">I", zlib.crc32(b"IHDR" + head))
    body = struct.pack(">I", 0) + b"IDAT"
    (folder / "bomb.png").write_bytes(b"\x89PNG\r\n\x1a\n" + chunk + body)
    (folder / "cut.jpg").write_bytes(good.read_bytes()[:3000])
    (folder / "empty.jpg").write_bytes(b"")
    (folder / "phone.jpg").write_bytes(b"\0\0\0\x18ftypheic\0\0\0\0mif1heic")
    Image.new("RGB", (1, 1)).save(folder / "point.png")
    Image.new("RGB", (20000, 10)).save(folder / "strip.png")
    (folder / "text.jpg").write_text("the kitchen")


def odd(data, row):
    folder, good = data / "photos", photos_of(row)
    damaged(folder, folder / good[0])
    odd_copies([folder / name for name in good])
    table = data / row["assignment"]
    room = table.read_text().splitlines()[1].split(",")[0]
    table.write_text(table.read_text() + "".join(f"{room},{name}\n" for name in BAD))
    row["photos"] = "|".join([*good, *BAD])
    unmeasured(data / row["plan"])


def unknown_room_type(data, row):
    scene = json.loads((data / row["plan"]).read_text())
    scene["scene"]["arch"]["rooms"][0]["types"] = ["Dungeon"]
    (data / row["plan"]).write_text(json.dumps(scene))


def empty_table(data, row):
    (data / row["assignment"]).write_text("room_id,photo\n")


def long_photo_name(data, row):
    old, name = photos_of(row)[0], "n" * 300 + ".jpg"
    row["photos"] = row["photos"].replace(old, name)
    table = data / row["assignment"]
    table.write_text(table.read_text().replace(old, name))


#: name: (what is broken, a word of the line, does the house go on)
CASES = {
    "long_photo_name": (long_photo_name, "at most 240 bytes", False),
    "unknown_room_type": (unknown_room_type, "Dungeon", False),
    "empty_table": (empty_table, "photo", True),
}


def renamed(row, name, data):
    copy = {"house": name, "split": "test", "plan": f"{name}/p.scene.json"}
    copy["assignment"] = f"{name}/a.csv"
    names = {photo: f"{name}_{photo}" for photo in photos_of(row)}
    copy["photos"] = "|".join(names.values())
    (data / name).mkdir(parents=True)
    (data / "photos").mkdir(exist_ok=True)
    shutil.copy(DEMO / row["plan"], data / copy["plan"])
    table = (DEMO / row["assignment"]).read_text()
    for old, new in names.items():
        table = table.replace(old, new)
        shutil.copy(DEMO / "photos" / old, data / "photos" / new)
    (data / copy["assignment"]).write_text(table)
    return copy


def unmeasured(path):
    """Turn a plan into one that tells no height of ceilings, in our own format."""
    plan = house_to_plan(read_plan(path, "odd"))
    plan["heights"] = USUAL
    for room in plan["rooms"]:
        del room["height"]
    path.write_text(json.dumps(plan))


@pytest.fixture(scope="module")
def broken(tmp_path_factory, toy_site):
    scale = {"metres_per_pixel": 0.02}
    clone = make_clone(tmp_path_factory.mktemp("broken") / "clone", [], floorplans=scale)
    shutil.copytree(toy_site, clone.root / "src", dirs_exist_ok=True)
    data = clone.root / "data"
    Image.fromarray(flat_picture()).save(data / "flat.jpg")
    (data / "home.square").write_text("square 200")
    alone = {"split": "test", "assignment": "", "photos": ""}
    rows = [
        alone | {"house": "traced", "plan": "flat.jpg"},
        alone | {"house": "toy", "plan": "home.square"},
    ]
    for name, damage in {"odd": odd, **{name: case[0] for name, case in CASES.items()}}.items():
        rows.append(renamed(GOOD, name, data))
        damage(data, rows[-1])
    write_table(data, rows)
    targets = [HOUSES / name / "scene.json" for name in ("traced", *CASES)]
    targets += [HOUSES / "odd" / name for name in ("crops.parquet", "contact_sheet.png")]
    targets.append(Path("results/tiny/drop_0.0/toy/toy/textures"))
    run = clone.snakemake("--keep-going", "--", *map(str, targets))
    assert run.returncode != 0, run.stdout[-3000:]
    return clone, run.stdout


@pytest.mark.parametrize("name", CASES)
def test_each_fault_is_one_clear_line(broken, name):
    clone, output = broken
    _, word, goes_on = CASES[name]
    logs = "\n".join(path.read_text() for path in (clone.root / "logs").rglob(f"{name}.log"))
    lines = [line for line in logs.splitlines() if line.startswith(("WARNING", "ERROR"))]
    fitting = [line for line in lines if f"house {name}" in line and word in line]
    assert fitting, logs
    assert all("expected" in line and "found" in line for line in fitting)
    assert "Traceback" not in logs
    assert (clone.root / HOUSES / name / "scene.json").is_file() == goes_on
    assert fitting[0] in output  # listed where the user looks, warnings too


@pytest.mark.parametrize("name", BAD)
def test_a_photo_that_cannot_be_used_is_one_line(broken, name):
    clone, output = broken
    lines = json.loads((clone.root / HOUSES / "odd/masks/warnings.json").read_text())
    fitting = [line for line in lines if f"photo {name} " in line]
    assert len(fitting) == 1, lines
    assert BAD[name] in fitting[0] and "expected" in fitting[0]
    assert fitting[0] in output  # where the user looks
    assert "Traceback" not in output


def test_odd_photos_are_used_like_others(broken):
    folder = broken[0].root / HOUSES / "odd"
    good = {f"odd_{name}": name for name in photos_of(GOOD)[:4]}
    cameras = json.loads((folder / "masks" / "cameras.json").read_text())
    assert set(good) <= set(cameras) and not set(BAD) & set(cameras)
    for name, original in good.items():
        with Image.open(DEMO / "photos" / original) as image:
            assert (cameras[name]["width"], cameras[name]["height"]) == image.size
    crops, _ = read_parquet(folder / "crops.parquet")
    assert set(good) & set(crops["photo"])
    assert not set(BAD) & set(crops["photo"])
    with Image.open(folder / "contact_sheet.png") as sheet:
        assert sheet.size[1] > 200 * (len(good) + len(BAD))


def test_a_plan_that_is_a_picture_is_traced_before_it_is_read(broken):
    made = {path.name for path in (broken[0].root / HOUSES / "traced").iterdir() if path.is_file()}
    assert {"scene.json", "plan.json", "plan.overlay.png", "plan.doubts.txt"} <= made


def test_photos_tell_how_high_a_house_is_whose_plan_does_not(broken):
    folder = broken[0].root / HOUSES / "odd"
    names = ("drawn.scene.json", "scene.json")
    drawn_as, made = (read_scene_json(folder / name, "odd") for name in names)
    assert (drawn_as.heights, made.heights) == (USUAL, FROM_PHOTOS)
    true = read_plan(DEMO / GOOD["plan"], "odd").rooms[0].height
    assert {room.height for room in drawn_as.rooms} == {2.8}
    assert made.rooms[0].height == pytest.approx(true, abs=0.08)
    # Houses whose plans tell their heights have no such job.
    assert not (folder.parent / "empty_table" / "drawn.scene.json").exists()


def test_another_package_reads_a_plan_and_makes_textures_by_name(broken):
    folder = broken[0].root / "results/tiny/drop_0.0/toy/toy/textures"
    listing = json.loads((folder / "textures.json").read_text())
    surfaces = {"hall/floor", "hall/wall", "hall/ceiling"}
    assert (listing["method"], set(listing["surfaces"])) == ("toy", surfaces)
    assert (read_image(folder / "hall_floor.png") == 128).all()
