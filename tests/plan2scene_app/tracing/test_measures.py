import pytest

from plan2scene_app.tracing.scale import read_area, read_length, read_sides


@pytest.mark.parametrize(
    ("text", "metres"),
    [
        ("3.20 m", [3.2]),
        ("3,20", [3.2, 0.032]),
        ("3200", [3.2, 32.0]),
        ("320", [0.32, 3.2]),
        ("320 cm", [3.2]),
        ("3200mm", [3.2]),
        ("12'6\"", [3.81]),
        ("12' 6''", [3.81]),
        ("12'-6”", [3.81]),
        ("12 ft 6 in", [3.81]),
        ("11'", [3.3528]),
        ("12'13\"", []),
        ("Bedroom 2", []),
        ("7", []),
        ("99999", []),
        ("", []),
    ],
)
def test_lengths(text, metres):
    expected = [value for value in metres if value >= 0.3]
    assert read_length(text) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("text", "square_metres", "digit"),
    [
        ("14,5 m2", 14.5, 0.1),
        ("13m²", 13.0, 1.0),
        ("Wohnen 21.37 qm", 21.37, 0.01),
        ("6.2 sqm", 6.2, 0.1),
        ("215 sq ft", 19.97, 0.0929),
        ("100 ft²", 9.29, 0.0929),
    ],
)
def test_areas(text, square_metres, digit):
    assert read_area(text) == pytest.approx((square_metres, digit), rel=1e-3)


@pytest.mark.parametrize("text", ["3.20 m", "14,5", "1 m2x", "100000 m2", "m2"])
def test_what_is_no_area(text):
    assert read_area(text) is None


@pytest.mark.parametrize(
    ("text", "sides"),
    [
        ("3.20 x 4.10 m", (3.2, 4.1)),
        ("3,20m × 4,10m", (3.2, 4.1)),
        ("322 X 347", (3.22, 3.47)),
        ("352 X332", (3.52, 3.32)),
        ("12'6\" x 10'2\"", (3.81, 3.0988)),
        ("3200x4100", (3.2, 4.1)),
    ],
)
def test_sides(text, sides):
    assert any(found == pytest.approx(sides) for found in read_sides(text))


@pytest.mark.parametrize("text", ["3.20", "Box x 4", "x", "2 x 4 x 6"])
def test_what_are_no_sides(text):
    assert read_sides(text) == []
