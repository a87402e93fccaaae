import pytest
from plan_drawing import FLATS, assert_found, body, drawn_flat, refusal

from plan2scene.errors import InputError
from plan2scene.plans.formats import read_plan
from plan2scene.plans.geometry import room_polygon
from plan2scene_app.plan_formats import cubicasa

PIXELS = 50  # a metre


def polygon(area, pixels=PIXELS):
    points = " ".join(f"{x * pixels:.4f},{z * pixels:.4f}" for x, z in area.exterior.coords)
    return f'<polygon points="{points} "/>'


def group(kind, area, text="", **more):
    return f'<g class="{kind}">{polygon(area, **more)}{text}</g>'


def sides(area):
    x0, y0, x1, y1 = area.bounds
    feet = [divmod(round(side / 0.0254), 12) for side in (y1 - y0, x1 - x0)]
    return " x ".join(f"{foot}'{inch}\"" for foot, inch in feet)


def elements(plan, *, written=None):
    parts = []
    for _, types, area in plan.rooms:
        text = f"<text>{written(area)}</text>" if written else ""
        parts.append(group(f"Space {' / '.join(types)}", area, text))
    parts += [group("Wall", body(ends, plan.thickness, "square")) for ends in plan.axes]
    for hole in plan.holes:
        kind = {"door": "Door Swing Beside", "window": "Window Regular", "passage": "Door None"}
        parts.append(group(kind[hole.kind], body(hole.ends, plan.thickness, "flat")))
    return "".join(parts)


def svg(tmp_path, inside, head='viewBox="0 0 1000 1000"'):
    path = tmp_path / "model.svg"
    doctype = '<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://x/svg11.dtd">'
    start = f'<?xml version="1.0"?>{doctype}<svg xmlns="http://www.w3.org/2000/svg" {head}>'
    path.write_text(f"{start}{inside}</svg>")
    return path


@pytest.mark.parametrize("number", range(len(FLATS)))
def test_round_trip(tmp_path, number):
    plan = drawn_flat(number)
    assert_found(plan, read_plan(svg(tmp_path, elements(plan)), "h1", 1 / PIXELS), heights=False)


@pytest.mark.parametrize("written", [lambda area: f"{area.area:.2f} m²", sides])
def test_the_scale_is_read_from_written_sizes(tmp_path, written):
    plan = drawn_flat(2)
    found = read_plan(svg(tmp_path, elements(plan, written=written)), "h1")
    (line,) = [line for line in found.warnings if "read from 4 written sizes" in line]
    assert float(line.split("none; ")[1].split()[0]) == pytest.approx(0.02, rel=0.003)
    assert len(found.rooms) == len(plan.rooms)


def test_the_scale_is_read_from_the_page_and_transforms_are_followed(tmp_path):
    plan = drawn_flat(2)
    head = 'width="20m" viewBox="0 0 1000 1000"'
    assert_found(plan, read_plan(svg(tmp_path, elements(plan), head), "h1"), heights=False)
    turned = f'<g transform="rotate(90)">{elements(plan)}</g>'
    inside = f'<g transform="translate(10 5) scale(2)">{turned}</g>'
    found = read_plan(svg(tmp_path, inside), "h1", 0.5 / PIXELS)
    areas = sorted(room_polygon(room).area for room in found.rooms)
    assert areas == pytest.approx(sorted(area.area for _, _, area in plan.rooms), rel=0.005)


@pytest.mark.parametrize("width", ["1.2.3m", ".m", "1e999m", "20km"])
def test_a_page_of_no_known_width_tells_no_scale(tmp_path, width):
    path = svg(tmp_path, SQUARE.format(""), f'width="{width}" viewBox="0 0 9 9"')
    with pytest.raises(InputError, match="metres_per_pixel up to 1"):
        read_plan(path, "h1")


def test_the_storey_with_most_floor_is_read(tmp_path):
    large, small = drawn_flat(2), drawn_flat(0)
    floors = (("a", small), ("b", large))
    inside = "".join(f'<g class="Floor" id="{n}">{elements(p)}</g>' for n, p in floors)
    found = read_plan(svg(tmp_path, inside), "h1", 1 / PIXELS)
    assert_found(large, found, heights=False)
    assert any("2; b read, left out a" in line for line in found.warnings)


SQUARE = '<g class="Space Kitchen"><polygon points="0,0 100,0 100,100 0,100"/>{}</g>'


@pytest.mark.parametrize(
    ("inside", "line"),
    [
        ("<g id='Wall'/>", "groups of class Space or Wall, as CubiCasa has them, found none"),
        (SQUARE.format(""), "metres_per_pixel up to 1, or areas or sides written in the rooms"),
        (SQUARE.format("<text>0 m2</text>"), "metres_per_pixel up to 1"),
        ('<g class="Wall"><polygon points="0,0 1,0"/></g>', "a polygon of at least 3 points"),
        ('<g class="Wall"><polygon points="0,0 1,0 1,1e300"/></g>', "coordinates below 1e7"),
        ('<g id="Wall" transform="scale()"/>', "an SVG transform, found scale()"),
        ("<g id='Wall'>" * 200 + "</g>" * 200, "SVG groups at most 100 deep"),
        ("<g id='Wall'>", "expected XML, found a syntax error"),
        (SQUARE.format("") * 3, "at most 2 walls and rooms"),
    ],
)
def test_bad_drawings_are_one_line(tmp_path, monkeypatch, inside, line):
    monkeypatch.setattr(cubicasa, "MAX_ITEMS", 2)
    assert line in refusal(svg(tmp_path, inside))
