from plan2scene_app.tracing.legend import with_legend

from .conftest import line

ROOMS = [line("1", 100, 100, (8, 12)), line("(2)", 200, 100, (20, 12)), line("3.", 100, 200)]
LIST = [("1", "Kitchen", "9.1 m²"), ("2", "Bath", "6.0 m²"), ("3", "Bedroom 1", "")]


def test_numbers_in_rooms_get_the_names_and_areas_of_a_list():
    cells = [
        line(text, x, 100 + 20 * k, (8 * len(text), 12))
        for k, row in enumerate(LIST)
        for x, text in zip((500, 580, 680), row, strict=True)
        if text
    ]
    caption = line("Ground floor", 100, 300)
    told = ["Kitchen 9.1 m²", "Bath 6.0 m²", "Bedroom 1"]
    found = with_legend([*ROOMS, caption, *cells])
    assert [(x.text, x.middle) for x in found[:3]] == [
        (text, x.middle) for text, x in zip(told, ROOMS, strict=True)
    ]
    assert found[3:] == [caption]
    joined = [line(f"{a}. {b} {c}", 560, 100 + 20 * k) for k, (a, b, c) in enumerate(LIST)]
    assert [x.text.strip() for x in with_legend([*ROOMS, *joined])] == told


def test_without_a_list_all_lines_stay():
    names = [line("2 Bedroom", 100, 100), line("3 Bedroom", 300, 140), line("Kitchen", 200, 200)]
    for lines in (ROOMS, names, [*ROOMS[:2], *names]):
        assert with_legend(lines) == lines
