"""The user study: sheets, the form in a browser, and what is made of answers.

All answers here are synthetic: no person gave them.
"""

import csv
import os
import re
import shutil
import subprocess
from collections import Counter
from math import comb

import numpy as np
import pytest
from PIL import Image

from plan2scene.errors import InputError
from plan2scene.evaluation.study_answers import (
    Answer,
    preferences,
    read_answers,
    read_key,
    study_result,
    wilson_interval,
)
from plan2scene.evaluation.study_form import make_questions, study_houses, write_study
from plan2scene.evaluation.study_sheet import write_study_sheet
from plan2scene.images import write_png
from plan2scene.io import read_json, write_json

PAIRS = [["synth", "crop"], ["exemplar", "synth"]]
HOUSES = [f"home_{i}" for i in range(7)]
BROWSER = next(filter(None, map(shutil.which, ("chromium", "google-chrome"))), None)


def _paint(folder, plan, level):
    """Write textures of one grey level for every surface of a plan."""
    entries = {}
    for key in plan.surface_keys():
        write_png(folder / f"{key.filename}.png", np.full((16, 16, 3), level, np.uint8))
        entries[f"{key.room_id}/{key.surface}"] = {"size_m": 1.0, "observed": True}
    write_json(folder / "textures.json", {"surfaces": entries})
    return folder


def test_a_sheet_has_plan_photos_and_a_render_by_each_method(plan, tmp_path):
    for name in ("b.jpg", "a.jpg"):
        Image.new("RGB", (640, 480), (200, 30, 30)).save(tmp_path / name)
    (tmp_path / "broken.jpg").write_text("no photo")
    methods = {
        name: _paint(tmp_path / name, plan, level) for name, level in (("x", 40), ("y", 220))
    }
    names = ("b.jpg", "a.jpg", "broken.jpg")
    write_study_sheet(
        tmp_path / "sheet",
        house=plan,
        photos={name: tmp_path / name for name in names},
        rooms_of_photo={"b.jpg": ["bed"], "a.jpg": ["bed", "hall"], "broken.jpg": ["bath"]},
        textures=methods,
    )
    sheet = read_json(tmp_path / "sheet" / "sheet.json")
    assert sheet == {"house": "h1", "photos": ["photo_1.jpg", "photo_2.jpg"], "methods": ["x", "y"]}
    assert Image.open(tmp_path / "sheet" / "photo_1.jpg").size == (320, 240)
    renders = [np.asarray(Image.open(tmp_path / "sheet" / f"{name}.jpg")) for name in ("x", "y")]
    middle = [image[300:420, 300:420].mean() for image in renders]
    assert middle[0] < 90 < 150 < middle[1]  # no ceiling hides the floors
    assert np.abs(renders[0][0, 0].astype(int) - renders[1][0, 0]).max() < 4  # background


def test_every_pair_of_every_house_once_and_sides_even():
    questions = make_questions(HOUSES, PAIRS, seed=3)
    assert [q.question for q in questions] == [f"q{i:03d}" for i in range(1, 15)]
    asked = Counter((q.house, frozenset((q.left, q.right))) for q in questions)
    assert asked == {(h, frozenset(pair)): 1 for h in HOUSES for pair in PAIRS}
    for first, second in PAIRS:
        left = sum((q.left, q.right) == (first, second) for q in questions)
        assert left in (3, 4)
    assert questions == make_questions(HOUSES, PAIRS, seed=3)
    other = make_questions(HOUSES, PAIRS, seed=4)
    assert [(q.house, q.left) for q in other] != [(q.house, q.left) for q in questions]
    assert other[0].form != questions[0].form


def test_houses_are_drawn_by_seed():
    assert sorted(study_houses(HOUSES, 20, seed=0)) == HOUSES
    drawn = study_houses(HOUSES, 3, seed=0)
    assert len(set(drawn)) == 3
    assert drawn == study_houses(HOUSES[::-1], 3, seed=0)


@pytest.fixture
def form(tmp_path):
    """A form over two houses with pictures of one colour each."""
    folders = []
    for i, house in enumerate(HOUSES[:2]):
        folder = tmp_path / house
        folder.mkdir()
        for j, name in enumerate(("plan", "photo_1", "synth", "crop", "exemplar")):
            Image.new("RGB", (8, 8), (40 * j, 100 * i, 90)).save(folder / f"{name}.jpg")
        write_json(folder / "sheet.json", {"photos": ["photo_1.jpg"]})
        folders.append(folder)
    paths = (tmp_path / "form.html", tmp_path / "key.csv")
    write_study(folders, *paths, houses=HOUSES[:2], pairs=PAIRS, seed=0)
    return paths


def test_the_form_is_blind_and_needs_no_network(form):
    page = form[0].read_text()
    assert "default-src 'none'" in page
    assert not re.search(r"https?://", page)
    for word in ("synth", "crop", "exemplar", *HOUSES[:2]):
        assert not re.search(rf"\b{word}\b", page)
    assert "There\nare 4 questions" in page
    key = read_key(form[1])
    assert {(q.left, q.right) for q in key.values()} <= {
        pair for a, b in PAIRS for pair in ((a, b), (b, a))
    }


@pytest.mark.skipif(BROWSER is None, reason="no Chromium on PATH")
def test_answers_given_in_a_browser_are_read_back(form, tmp_path):
    page = tmp_path / "driven.html"
    script = """<script>
    for (const side of ["left", "right", "right", "left"]) get(side).click();
    get("back").click(); get("left").click();
    const out = document.createElement("pre");
    out.id = "out"; out.textContent = csv("tester_1"); document.body.append(out);
    </script></body>"""
    page.write_text(form[0].read_text().replace("</body>", script))
    command = [BROWSER, "--headless=new", "--no-sandbox", "--disable-background-networking"]
    command += [f"--user-data-dir={tmp_path / 'profile'}", "--dump-dom", page.as_uri()]
    environment = {**os.environ, "HOME": str(tmp_path)}
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=120, env=environment, check=False
    )
    found = re.search(r'<pre id="out">(.*?)</pre>', done.stdout, re.DOTALL)
    assert found, done.stderr[-2000:]
    answers = tmp_path / "answers.csv"
    answers.write_text(found[1])
    read = read_answers(answers, read_key(form[1]))
    # Back from the last question (which stays shown) leads to the third: answered again.
    assert [(a.participant, a.question, a.choice) for a in read] == [
        ("tester_1", "q001", "left"),
        ("tester_1", "q002", "right"),
        ("tester_1", "q003", "left"),
        ("tester_1", "q004", "left"),
    ]


def test_wilson_interval():
    # Newcombe 1998, table I: 81 of 263, and 0 of 20 and 1 of 29.
    assert wilson_interval(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)
    assert wilson_interval(0, 20) == pytest.approx((0.0, 0.1611), abs=5e-5)
    assert wilson_interval(1, 29) == pytest.approx((0.0061, 0.1718), abs=5e-5)
    low, high = wilson_interval(9, 9)
    assert high == 1.0
    assert low == pytest.approx(1 - wilson_interval(0, 9)[1])
    with pytest.raises(ValueError, match="total"):
        wilson_interval(0, 0)


def test_the_interval_holds_the_true_share_about_as_often_as_it_says():
    total, share = 40, 0.7
    held = sum(
        comb(total, count) * share**count * (1 - share) ** (total - count)
        for count in range(total + 1)
        if wilson_interval(count, total)[0] <= share <= wilson_interval(count, total)[1]
    )
    assert 0.92 < held < 0.98


HEADER = "form,participant,question,choice,seconds"


def _row(key, question="q001", participant="synthetic_1", choice="left", seconds="3.5"):
    form = next(iter(key.values())).form
    return f"{form},{participant},{question},{choice},{seconds}"


def test_preferences_count_the_method_wherever_it_stood(form):
    key = read_key(form[1])
    answers = []
    for question in key.values():
        for person, wins in (("synthetic_1", "synth"), ("synthetic_2", "crop")):
            choice = "left" if question.left == wins else "right"
            answers.append(Answer(person, question.question, choice))
    found = {(p.method, p.other): p for p in preferences(key, answers, PAIRS)}
    pair = found["synth", "crop"]
    assert (pair.participants, pair.answers, pair.chosen, pair.share) == (2, 4, 2, 0.5)
    assert (pair.low, pair.high) == wilson_interval(2, 4)
    # Who looks for crop always takes the right where there is none.
    exemplar = sum(q.right == "exemplar" for q in key.values() if "exemplar" in (q.left, q.right))
    assert found["exemplar", "synth"].chosen == exemplar


BAD = {
    "another header": "a,b\n1,2\n",
    "an empty file": "",
    "another form": HEADER + "\n000000000000,p,q001,left,1\n",
    "an unknown question": HEADER + "\n{row}\n",
    "a third choice": HEADER + "\n{row}\n",
    "a formula for a name": HEADER + "\n{row}\n",
    "a negative time": HEADER + "\n{row}\n",
    "no number": HEADER + "\n{row}\n",
    "a column too many": HEADER + "\n{row},x\n",
    "an answer twice": HEADER + "\n{row}\n{row}\n",
    "an open quote": HEADER + '\n"{row}\n',
}
CHANGES = {
    "an unknown question": {"question": "q999"},
    "a third choice": {"choice": "both"},
    "a formula for a name": {"participant": "=HYPERLINK(1)"},
    "a negative time": {"seconds": "-1"},
    "no number": {"seconds": "nan"},
}


@pytest.mark.parametrize("fault", BAD)
def test_files_that_are_not_as_the_form_writes_them_are_refused(form, tmp_path, fault):
    key = read_key(form[1])
    path = tmp_path / "bad.csv"
    path.write_text(BAD[fault].format(row=_row(key, **CHANGES.get(fault, {}))))
    with pytest.raises(InputError, match=r"bad\.csv") as caught:
        read_answers(path, key)
    assert "\n" not in str(caught.value)


def test_bytes_that_are_no_text_and_huge_files_are_refused(form, tmp_path):
    key = read_key(form[1])
    path = tmp_path / "bad.csv"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="UTF-8"):
        read_answers(path, key)
    path.write_text(HEADER + "\n" + "x" * 1_000_001)
    with pytest.raises(InputError, match="bytes"):
        read_answers(path, key)


def test_the_result_counts_good_files_and_names_the_others(form, tmp_path):
    key = read_key(form[1])
    lines = [HEADER, *(_row(key, question) for question in key)]
    (tmp_path / "a.csv").write_text("\n".join(lines) + "\n")
    (tmp_path / "b.csv").write_text("\n".join(lines) + "\n")  # the same person again
    (tmp_path / "c.csv").write_text("rubbish\n")
    files = [tmp_path / f"{name}.csv" for name in "abc"]
    outputs = (tmp_path / "study.csv", tmp_path / "study.txt")
    found = study_result(form[1], files, *outputs, pairs=PAIRS)
    assert [(p.participants, p.answers) for p in found] == [(1, 2), (1, 2)]
    rows = list(csv.DictReader(outputs[0].open()))
    assert [row["published_share"] for row in rows] == ["0.669", "none"]
    assert float(rows[0]["low_95"]) <= float(rows[0]["share"]) <= float(rows[0]["high_95"])
    text = outputs[1].read_text()
    assert "1 of 3 files counted" in text
    assert re.search(r"refused: .*b\.csv.*synthetic_1 again", text)
    assert re.search(r"refused: .*c\.csv", text)
    with pytest.raises(InputError, match="answers"):
        study_result(form[1], files[2:], *outputs, pairs=PAIRS)
    with pytest.raises(InputError, match="0 files"):
        study_result(form[1], [], *outputs, pairs=PAIRS)
