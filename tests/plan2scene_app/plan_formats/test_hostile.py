import math
import random
import re
import resource
import time
import zipfile
from pathlib import Path

import pytest

from plan2scene.errors import InputError
from plan2scene.plans.formats import one_line, plan_formats, read_plan
from plan2scene.plans.plan_file import PlanFile

CHANCE = random.Random(0)
ROOM = '<room id="r">{}</room>'
CORNERS = [(0, 0), (400, 0), (400, 300), (0, 300)]
STAR = [(900 * math.cos(k), 900 * math.sin(k)) for k in range(9000)]


@pytest.fixture(autouse=True)
def bounded():
    """Each takes at most 20 s, and 1 GB beside what the tests hold already."""
    held = int(re.search(r"VmData:\s*(\d+)", Path("/proc/self/status").read_text())[1]) * 1024
    before = resource.getrlimit(resource.RLIMIT_DATA)
    resource.setrlimit(resource.RLIMIT_DATA, (held + 10**9, before[1]))
    began = time.perf_counter()
    yield
    resource.setrlimit(resource.RLIMIT_DATA, before)
    assert time.perf_counter() - began < 20


def room(points):
    return ROOM.format("".join(f'<point x="{x:.1f}" y="{y:.1f}"/>' for x, y in points))


def wall(x0, y0, x1, y1):
    ends = f'xStart="{x0:.2f}" yStart="{y0:.2f}" xEnd="{x1:.2f}" yEnd="{y1:.2f}"'
    return f'<wall {ends} thickness="10"/>'


def scattered(spread):
    return [wall(*(v + CHANCE.uniform(0, spread) for v in (0, 0, 400, 0))) for _ in range(5000)]


@pytest.mark.parametrize(
    ("parts", "found"),
    [
        ([wall(0, 0, 400, 0)] * 5000, ""),
        (scattered(0.05), ""),
        (scattered(0.9), "pairs of walls that meet"),
        (scattered(90), "pairs of walls that meet"),
        ([wall(20 * k, 0, 9000 - 20 * k, 9000) for k in range(4000)], "pairs of walls that meet"),
        ([room(STAR)], "corners of all rooms, found 9004"),
        ([f'<level id="{k}" elevation="{300 * k}" height="250"/>' for k in range(60)], ""),
        ([room(CORNERS)] * 400, ""),
    ],
)
def test_a_home_of_too_much(tmp_path, parts, found):
    with zipfile.ZipFile(tmp_path / "home.sh3d", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("Home.xml", f"<home>{room(CORNERS)}{''.join(parts)}</home>")
    try:
        house = read_plan(tmp_path / "home.sh3d", "h1")
    except InputError as error:
        assert found
        assert found in str(error)
    else:
        assert not found
        assert house.rooms[0].rings[0] == tuple((x / 100, z / 100) for x, z in CORNERS)


@pytest.mark.parametrize("layer", ["WALL", "DOOR"])
def test_a_drawing_of_too_many_lines(tmp_path, layer):
    pytest.importorskip("ezdxf")
    rows = ["0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n6\n0\nENDSEC\n0\nSECTION\n2\nENTITIES"]
    for _ in range(4000):
        x0, y0, y1 = (CHANCE.uniform(0, 0.5) for _ in range(3))
        ends = f"10\n{x0:.3f}\n20\n{y0:.3f}\n11\n{x0 + 4:.3f}\n21\n{y1:.3f}"
        rows.append(f"0\nLINE\n8\n{layer}\n{ends}")
    (tmp_path / "plan.dxf").write_text("\n".join([*rows, "0\nENDSEC\n0\nEOF\n"]))
    with pytest.raises(InputError, match=r"pairs of lines of .* side by side, found more"):
        read_plan(tmp_path / "plan.dxf", "h1")


def test_a_long_attribute_takes_no_square_of_its_length(tmp_path):
    text = f'<svg><g class="Wall"><polygon points="{"1,1 " * 3_000_000}"/></g></svg>'
    (tmp_path / "plan.svg").write_text(text)
    with pytest.raises(InputError, match="letters of a polygon's points"):
        read_plan(tmp_path / "plan.svg", "h1")


def test_what_no_reader_foresaw_is_one_line_with_its_cause(tmp_path, caplog):
    caplog.set_level("INFO")
    (tmp_path / "plan.txt").write_text("x")
    plan, plan_format = PlanFile(tmp_path / "plan.txt", "h1"), plan_formats()[0]
    with pytest.raises(InputError) as found, one_line(plan, plan_format):
        raise StopIteration("in a\npoint")
    assert str(found.value).startswith(f"file {plan.path}, house h1: expected {plan_format.name}")
    assert "found StopIteration: in a point (not foreseen" in str(found.value)
    assert isinstance(found.value.__cause__, StopIteration) and "Traceback" in caplog.text
    named = pytest.raises(InputError, match=r"plan\.txt, house h1: expected a, found b")
    with named, one_line(plan, plan_format):
        raise InputError("a", "b")
