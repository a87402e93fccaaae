import pytest

from plan2scene_app.plan_formats import measures
from plan2scene_app.tracing.scale import RoomSize, chain_evidence, find_scale, room_evidence
from plan2scene_app.tracing.settings import SETTINGS

from .conftest import line

LENGTHS = {
    3.2: "3.20 m|320 cm|3200mm",
    3.81: "12'6\"|12' 6''|12'-6”|12 ft 6 in",
    3.3528: "11'",
    None: "12'13\"|Bedroom 2|7|99999|",
}


@pytest.mark.parametrize("metres", LENGTHS)
def test_lengths(metres):
    expected = [] if metres is None else [pytest.approx(metres)]
    texts = LENGTHS[metres].split("|")
    assert {text: measures.read_length(text) for text in texts} == dict.fromkeys(texts, expected)


def test_lengths_without_a_unit():
    """What is shorter than 30 cm is none."""
    assert measures.read_length("3,20") == pytest.approx([3.2])
    assert measures.read_length("3200") == pytest.approx([3.2, 32.0])
    assert measures.read_length("320") == pytest.approx([0.32, 3.2])


AREAS = {
    "14,5 m2": (14.5, 0.1),
    "13m²": (13.0, 1.0),
    "Wohnen 21.37 qm": (21.37, 0.01),
    "6.2 sqm": (6.2, 0.1),
    "cuc. mq. 9,15": (9.15, 0.01),
    "6,2 mq 3": (6.2, 0.1),
    "215 sq ft": (19.97, 0.0929),
    "100 ft²": (9.29, 0.0929),
    "12,3 м2": (12.3, 0.1),
    "12,3 кв. м": (12.3, 0.1),
    "洋室 6.0帖": (9.72, 0.162),
}


@pytest.mark.parametrize("text", AREAS)
def test_areas(text):
    assert measures.read_areas(text) == [pytest.approx(AREAS[text], rel=1e-3)]


SIDES = {
    (3.2, 4.1): "3.20 x 4.10 m|3,20m × 4,10m|3200x4100",
    (3.22, 3.47): "322 X 347",
    (3.52, 3.32): "352 X332",
    (3.81, 3.0988): "12'6\" x 10'2\"|12'6\" (3.81m) x 10'2\" (3.10m)|(12'6\" x 10'2\")"
    "|12'6 max x 10'2 into bay",
    (3.566, 3.688): "~11.7× 12.1",
    (3.353, 3.536): "11 x 11.6",
    (3.81, 3.1): "3.81m x 3.10m (12'6\" x 10'2\")|Bedroom 2 3.81m by 3.10m",
}


@pytest.mark.parametrize("sides", SIDES)
def test_sides(sides):
    for text in SIDES[sides].split("|"):
        found = measures.read_sides(text)
        assert any(pair == pytest.approx(sides, rel=1e-3) for pair in found), text


@pytest.mark.parametrize(
    ("read", "texts"),
    [
        (measures.read_areas, "3.20 m|14,5|1 m2x|100000 m2|m2"),
        (measures.read_sides, "Bedroom 2|Suite 2x|3.81m x|2 4"),
    ],
)
def test_what_tells_no_measure(read, texts):
    assert [read(text) for text in texts.split("|")] == [[]] * (texts.count("|") + 1)


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("Lounge 4.2m x 3.1m (13'9 x 10'2)", "Lounge"),
        ("Wohnen 21,37 qm", "Wohnen"),
        ("cuc. mq 9,15", "cuc."),
        ("Bedroom 1 (rear)", "Bedroom 1 (rear)"),
        ("12'6 max x 10'2", ""),
    ],
)
def test_a_name_beside_its_measures(text, name):
    assert measures.without_measures(text) == name


TRUE = 0.02


def room(width, depth, *texts):
    sides = width / TRUE, depth / TRUE
    return RoomSize(sides[0] * sides[1], sides, [line(text) for text in texts])


def test_areas_and_sides_agree_and_a_wrong_text_is_outvoted_and_named():
    evidence = [
        *room_evidence(room(4.0, 3.0, "12 m2", "400 x 300")),
        *room_evidence(room(2.0, 3.0, "6.0 m2")),
    ]
    found = find_scale(evidence, [0.9 / TRUE], [30000.0])
    assert found.metres_per_pixel == pytest.approx(TRUE, rel=0.01)
    assert found.confidence > SETTINGS.sure
    assert set(found.agree) == {"12 m2", "400 x 300", "6.0 m2"}
    evidence = [
        *room_evidence(room(4.0, 3.0, "12 m2")),
        *room_evidence(room(2.0, 3.0, "6.0 m2")),
        *room_evidence(room(2.0, 2.0, "9.0 m2")),
    ]
    found = find_scale(evidence, [0.85 / TRUE] * 3, [30000.0])
    assert found.metres_per_pixel == pytest.approx(TRUE, rel=0.01)
    assert found.differ == ("9.0 m2",)


def test_chains_stand_in_the_middle_between_walls():
    walls = [100.0, 250.0, 450.0]
    texts = [line("3000", 175), line("4000", 350), line("7000", 275)]
    evidence = [chain_evidence(text, walls, []) for text in texts]
    found = find_scale([e for e in evidence if e], [0.8 / TRUE], [30000.0])
    assert found.metres_per_pixel == pytest.approx(TRUE, rel=0.01)
    assert chain_evidence(line("3000", 300), walls, []) is None
    assert chain_evidence(line("Hall", 175), walls, []) is None


def test_doors_tell_the_scale_where_no_text_or_one_far_off_does():
    found = find_scale([], [42.0, 43.0, 40.0], [30000.0])
    assert found.metres_per_pixel == pytest.approx(0.85 / 42, rel=0.01)
    assert found.confidence < SETTINGS.sure and "guess" in found.source
    assert find_scale([], [], [30000.0]).confidence < 0.2
    evidence = room_evidence(room(4.0, 3.0, "1200 m2", "120 m2"))
    found = find_scale(evidence, [0.85 / TRUE] * 3, [30000.0])
    assert found.metres_per_pixel == pytest.approx(TRUE, rel=0.01)
    assert found.confidence < SETTINGS.sure
