"""One bad house never stops the others, and each fault is one clear line (issue's show 7).

Every case is a house of its own in one data set; all are run together with ``--keep-going`` beside
one good house: up to their crops, those whose fault ends them earlier up to there.
"""

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from clones import DEMO, Clone, demo_rows, make_clone, photos_of, write_table

GOOD = demo_rows()[0] if (DEMO / "houses.tsv").is_file() else {}


def scene_of(data: Path, row: dict[str, str]) -> tuple[Path, dict]:
    path = data / row["plan"]
    return path, json.loads(path.read_text())


def elements(scene: dict, kind: str) -> list[dict]:
    arch = scene["scene"]["arch"]
    return [element for element in arch["elements"] if element["type"] == kind]


def missing_photo(data: Path, row: dict[str, str]) -> None:
    (data / "photos" / photos_of(row)[0]).unlink()


def corrupt_jpeg(data: Path, row: dict[str, str]) -> None:
    path = data / "photos" / photos_of(row)[0]
    path.write_bytes(path.read_bytes()[:2000])


def photo_outside(data: Path, row: dict[str, str]) -> None:
    table = data / row["assignment"]
    room = table.read_text().splitlines()[1].split(",")[0]
    table.write_text(table.read_text() + f"{room},../../secret.jpg\n")


def unknown_room_type(data: Path, row: dict[str, str]) -> None:
    path, scene = scene_of(data, row)
    scene["scene"]["arch"]["rooms"][0]["types"] = ["Dungeon"]
    path.write_text(json.dumps(scene))


def crossing_room(data: Path, row: dict[str, str]) -> None:
    path, scene = scene_of(data, row)
    for kind in ("Floor", "Ceiling"):
        points = elements(scene, kind)[0]["points"]
        ring = points[0] if isinstance(points[0][0], list) else points
        ring[0], ring[1] = ring[1], ring[0]
    path.write_text(json.dumps(scene))


def hole_outside(data: Path, row: dict[str, str]) -> None:
    path, scene = scene_of(data, row)
    wall = next(wall for wall in elements(scene, "Wall") if wall["holes"])
    box = wall["holes"][0]["box"]
    box["min"][0], box["max"][0] = box["min"][0] + 50.0, box["max"][0] + 50.0
    path.write_text(json.dumps(scene))


def unknown_room(data: Path, row: dict[str, str]) -> None:
    table = data / row["assignment"]
    table.write_text(table.read_text() + f"no_such_room,{photos_of(row)[0]}\n")


def empty_table(data: Path, row: dict[str, str]) -> None:
    (data / row["assignment"]).write_text("room_id,photo\n")


def other_photo_name(data: Path, row: dict[str, str], name: str) -> None:
    """Give a photo another name in both tables, and on disk where a disk takes it."""
    old = photos_of(row)[0]
    if len(name) < 250:
        (data / "photos" / old).rename(data / "photos" / name)
    row["photos"] = row["photos"].replace(old, name)
    table = data / row["assignment"]
    table.write_text(table.read_text().replace(old, name))


def braces_in_a_photo_name(data: Path, row: dict[str, str]) -> None:
    other_photo_name(data, row, "{house}_{x}.jpg")


def long_photo_name(data: Path, row: dict[str, str]) -> None:
    other_photo_name(data, row, "n" * 300 + ".jpg")


#: name: (what is broken, a word of the line, does the house go on)
CASES: dict[str, tuple[Callable[[Path, dict[str, str]], None], str, bool]] = {
    "missing_photo": (missing_photo, "no such file", True),
    "corrupt_jpeg": (corrupt_jpeg, ".jpg", True),
    "photo_outside": (photo_outside, "secret.jpg", False),
    "braces_in_a_photo_name": (braces_in_a_photo_name, "braces", False),
    "long_photo_name": (long_photo_name, "at most 240 bytes", False),
    "unknown_room_type": (unknown_room_type, "Dungeon", False),
    "crossing_room": (crossing_room, "room", False),
    "hole_outside": (hole_outside, "room", False),
    "unknown_room": (unknown_room, "no_such_room", False),
    "empty_table": (empty_table, "photo", True),
}


def renamed(row: dict[str, str], name: str, data: Path) -> dict[str, str]:
    """Return a copy of a demo house under another name, with files of its own."""
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


def last_of(name: str) -> str:
    """Return the file up to which a house is made: a fault of plan or table leaves no scene."""
    return "crops.parquet" if name not in CASES or CASES[name][2] else "scene.json"


@pytest.fixture(scope="session")
def broken(tmp_path_factory) -> tuple[Clone, str, int]:
    """Run good and bad houses together; return (clone, output, exit code)."""
    clone = make_clone(tmp_path_factory.mktemp("broken") / "clone", [])
    data = clone.root / "data"
    rows = [renamed(GOOD, "good", data)]
    for name, (damage, _, _) in CASES.items():
        rows.append(renamed(GOOD, name, data))
        damage(data, rows[-1])
    write_table(data, rows)
    targets = [f"results/tiny/houses/{row['house']}/{last_of(row['house'])}" for row in rows]
    run = clone.snakemake("--keep-going", "--", *targets)
    return clone, run.stdout, run.returncode


def test_the_run_fails_but_the_good_house_is_done(broken):
    clone, output, code = broken
    assert code != 0, output[-3000:]
    assert (clone.root / "results/tiny/houses/good/crops.parquet").is_file()


@pytest.mark.parametrize("name", sorted(CASES))
def test_each_fault_is_one_clear_line(broken, name):
    clone, output, _ = broken
    _, word, goes_on = CASES[name]
    logs = "\n".join(
        path.read_text() for path in (clone.root / "logs").rglob(f"{name}.log") if path.is_file()
    )
    lines = [line for line in logs.splitlines() if line.startswith(("WARNING", "ERROR"))]
    fitting = [line for line in lines if f"house {name}" in line and word in line]
    assert fitting, logs
    assert all("expected" in line and "found" in line for line in fitting)
    assert "Traceback" not in logs
    made = (clone.root / f"results/tiny/houses/{name}/{last_of(name)}").is_file()
    assert made == goes_on
    assert fitting[0] in output  # listed where the user looks, warnings too
