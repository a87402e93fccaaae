"""The user study: sheets, the form in a browser, and what is made of answers.

All answers here are synthetic: no person gave them.
"""

import csv
import re
from collections import Counter

import numpy as np
import pandas as pd
import pytest
from browser import chromium
from painted_house import textures_of
from PIL import Image
from sample_houses import rooms_in_a_row

from plan2scene.errors import InputError
from plan2scene.house import House
from plan2scene.io import read_json, write_json
from plan2scene_app.study import study
from plan2scene_app.study.study_sheet import write_study_sheet

PAIRS = [["synth", "crop"], ["exemplar", "synth"]]
HOUSES = [f"home_{i}" for i in range(7)]


def test_a_sheet_has_plan_photos_and_a_render_by_each_method(tmp_path):
    rooms = rooms_in_a_row(bed="Bedroom", hall="Corridor", bath="Bathroom", loft="Closet")
    plan = House("h1", rooms, ())
    for name in ("b.jpg", "a.jpg"):
        Image.new("RGB", (640, 480), (200, 30, 30)).save(tmp_path / name)
    (tmp_path / "broken.jpg").write_text("no photo")
    names = ["/".join(key) for key in plan.surface_keys()]
    grey = {n: np.full((16, 16, 3), level, np.uint8) for n, level in (("x", 40), ("y", 220))}
    methods = {n: textures_of(tmp_path / n, dict.fromkeys(names, grey[n])) for n in grey}
    rooms = {"b.jpg": ["bed"], "a.jpg": ["bed", "hall"], "broken.jpg": ["bath"]}
    told = dict(photos={name: tmp_path / name for name in rooms}, rooms_of_photo=rooms)
    write_study_sheet(tmp_path / "sheet", house=plan, textures=methods, **told)
    sheet = read_json(tmp_path / "sheet" / "sheet.json")
    assert sheet == {"house": "h1", "photos": ["photo_1.jpg", "photo_2.jpg"], "methods": ["x", "y"]}
    assert Image.open(tmp_path / "sheet" / "photo_1.jpg").size == (320, 240)
    renders = [np.asarray(Image.open(tmp_path / "sheet" / f"{name}.jpg")) for name in ("x", "y")]
    middle = [image[300:420, 300:420].mean() for image in renders]
    assert middle[0] < 90 < 150 < middle[1]  # no ceiling hides the floors
    assert np.abs(renders[0][0, 0].astype(int) - renders[1][0, 0]).max() < 4  # background


def test_every_pair_of_every_house_once_and_sides_even():
    questions = study.make_questions(HOUSES, PAIRS, seed=3)
    assert [q["question"] for q in questions] == [f"q{i:03d}" for i in range(1, 15)]
    asked = Counter((q["house"], frozenset((q["left"], q["right"]))) for q in questions)
    assert asked == {(h, frozenset(pair)): 1 for h in HOUSES for pair in PAIRS}
    for first, second in PAIRS:
        assert sum((q["left"], q["right"]) == (first, second) for q in questions) in (3, 4)
    assert questions == study.make_questions(HOUSES, PAIRS, seed=3)
    other = study.make_questions(HOUSES, PAIRS, seed=4)
    assert [q["left"] for q in other] != [q["left"] for q in questions]
    assert other[0]["form"] != questions[0]["form"]


def test_houses_are_drawn_by_seed():
    assert sorted(study.study_houses(HOUSES, 20, seed=0)) == HOUSES
    drawn = study.study_houses(HOUSES, 3, seed=0)
    assert len(set(drawn)) == 3 and drawn == study.study_houses(HOUSES[::-1], 3, seed=0)


@pytest.fixture
def form(tmp_path):
    folders = []
    for i, house in enumerate(HOUSES[:2]):
        folder = tmp_path / house
        folder.mkdir()
        for j, name in enumerate(("plan", "photo_1", "synth", "crop", "exemplar")):
            Image.new("RGB", (8, 8), (40 * j, 100 * i, 90)).save(folder / f"{name}.jpg")
        write_json(folder / "sheet.json", {"photos": ["photo_1.jpg"]})
        folders.append(folder)
    paths = (tmp_path / "form.html", tmp_path / "key.csv")
    study.write_study(folders, *paths, houses=HOUSES[:2], pairs=PAIRS, seed=0)
    return paths


def _key(form):
    return pd.read_csv(form[1], dtype=str)


def test_the_form_is_blind_and_needs_no_network(form):
    page = form[0].read_text()
    assert "default-src 'none'" in page and not re.search(r"https?://", page)
    for word in ("synth", "crop", "exemplar", *HOUSES[:2]):
        assert not re.search(rf"\b{word}\b", page)
    assert "There\nare 4 questions" in page
    key = _key(form)
    assert list(key) == ["form", "question", "house", "left", "right"]
    sides = map(frozenset, zip(key["left"], key["right"], strict=True))
    assert set(sides) == {frozenset(pair) for pair in PAIRS}


def test_answers_given_in_a_browser_are_read_back(form, tmp_path):
    answers = tmp_path / "answers.csv"
    with chromium() as browser:
        page = browser.new_page()
        page.goto(form[0].as_uri())
        for button in ("left", "right", "right", "left", "back", "left"):
            page.evaluate(f"get('{button}').click()")
        answers.write_text(page.evaluate("csv('tester_1')"))
    read = study.read_answers(answers, _key(form))
    # Back from the last question (which stays shown) leads to the third: answered again.
    assert set(read["participant"]) == {"tester_1"}
    assert read["question"].tolist() == ["q001", "q002", "q003", "q004"]
    assert read["choice"].tolist() == ["left", "right", "left", "left"]


HEADER = "form,participant,question,choice,seconds"


def _row(key, question="q001", participant="synthetic_1", choice="left", seconds="3.5"):
    return f"{key['form'][0]},{participant},{question},{choice},{seconds}"


def test_preferences_count_the_method_wherever_it_stood(form):
    key = _key(form)
    answers = pd.concat(
        [
            key[["form", "question"]].assign(
                participant=person, choice=np.where(key["left"] == name, "left", "right")
            )
            for person, name in (("a", "synth"), ("b", "crop"))
        ]
    )
    found = study.preferences(key, answers, PAIRS).set_index(["method", "other"])
    pair = found.loc["synth", "crop"]
    assert (pair["participants"], pair["answers"], pair["chosen"]) == (2, 4, 2)
    # Wilson's interval of 2 of 4: z / (n + z^2) sqrt(n p (1 - p) + z^2 / 4) about .5.
    z = 1.959964
    half = z / (4 + z**2) * np.sqrt(4 * 0.25 + z**2 / 4)
    assert (pair["low_95"], pair["high_95"]) == pytest.approx((0.5 - half, 0.5 + half), abs=1e-6)
    # Who looks for crop always takes the right where there is none.
    asked = key[(key["left"] == "exemplar") | (key["right"] == "exemplar")]
    assert found.loc["exemplar", "synth"]["chosen"] == (asked["right"] == "exemplar").sum()


@pytest.mark.parametrize(
    ("text", "change"),
    [
        ("a,b\n1,2\n", {}),
        ("", {}),
        (HEADER + "\n000000000000,p,q001,left,1\n", {}),  # of another form
        *((HEADER + "\n{row}\n", {"seconds": value}) for value in ("-1", "nan")),
        (HEADER + "\n{row}\n", {"question": "q999"}),
        (HEADER + "\n{row}\n", {"choice": "both"}),
        (HEADER + "\n{row}\n", {"participant": "=HYPERLINK(1)"}),
        (HEADER + "\n{row},x\n", {}),
        (HEADER + "\n{row}\n{row}\n", {}),
        (HEADER + '\n"{row}\n', {}),
    ],
)
def test_files_that_are_not_as_the_form_writes_them_are_refused(form, tmp_path, text, change):
    key = _key(form)
    path = tmp_path / "bad.csv"
    path.write_text(text.format(row=_row(key, **change)))
    with pytest.raises(InputError, match=r"bad\.csv") as caught:
        study.read_answers(path, key)
    assert "\n" not in str(caught.value)


def test_the_result_counts_good_files_and_names_the_others(form, tmp_path):
    key = _key(form)
    lines = [HEADER, *(_row(key, question) for question in key["question"])]
    (tmp_path / "a.csv").write_text("\n".join(lines) + "\n")
    (tmp_path / "b.csv").write_text("\n".join(lines) + "\n")  # the same person again
    (tmp_path / "c.csv").write_text("rubbish\n")
    files = [tmp_path / f"{name}.csv" for name in "abc"]
    outputs = (tmp_path / "study.csv", tmp_path / "study.txt")
    found = study.study_result(form[1], files, *outputs, pairs=PAIRS)
    assert list(zip(found["participants"], found["answers"], strict=True)) == [(1, 2), (1, 2)]
    rows = list(csv.DictReader(outputs[0].open()))
    assert [row["published_share"] for row in rows] == ["0.669", "none"]
    assert float(rows[0]["low_95"]) <= float(rows[0]["share"]) <= float(rows[0]["high_95"])
    text = outputs[1].read_text()
    assert "1 of 3 files counted" in text
    assert re.search(r"refused: .*b\.csv.*synthetic_1 again", text)
    assert re.search(r"refused: .*c\.csv", text)
    with pytest.raises(InputError, match="answers"):
        study.study_result(form[1], files[2:], *outputs, pairs=PAIRS)
    with pytest.raises(InputError, match="0 files"):
        study.study_result(form[1], [], *outputs, pairs=PAIRS)
