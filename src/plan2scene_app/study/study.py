"""The user study: forced choices between two renders in one offline HTML file, and their result.

As in the paper (section 6.5), a question shows the plan, the photos, and two methods' renders from
above without ceilings. The order of the questions and which method is on the left are random
(seeded). The form does not name the methods: they are in the key, a separate file.

Answer files come from strangers. A file with one invalid line is refused as a whole; the report
names each refused file and the reason.
"""

from __future__ import annotations

import base64
import hashlib
import json
import logging
import re
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from plan2scene.errors import InputError
from plan2scene.io import read_text, write_csv, write_text
from plan2scene.seeds import generator
from plan2scene.stage_json import read_stage_json
from plan2scene_app.html_page import html_page, inline_json, source_hash

_BODY = Path(__file__).with_name("study_form.html")


def study_houses(houses: Sequence[str], count: int, *, seed: int) -> list[str]:
    """Return `count` houses in a seeded random order; all of them if there are fewer."""
    order = generator(seed, "study", "houses").permutation(len(houses))
    return [sorted(houses)[i] for i in order[:count]]


def make_questions(
    houses: Sequence[str], pairs: Sequence[Sequence[str]], *, seed: int
) -> list[dict[str, str]]:
    """Return the key's rows: a question for each house and pair of methods, in random order.

    Sides are random, too: each method of a pair is on the left in half of the pair's questions (one
    more or less if their number is odd). ``form`` is the id of the form that has the question.
    """
    drawn: list[tuple[str, str, str]] = []
    for first, second in pairs:
        flip = generator(seed, "study", "sides", first, second).permutation(len(houses)) % 2 == 1
        drawn += [
            (house, second, first) if flipped else (house, first, second)
            for house, flipped in zip(houses, flip, strict=True)
        ]
    shuffled = [drawn[i] for i in generator(seed, "study", "order").permutation(len(drawn))]
    form = hashlib.sha256(json.dumps(shuffled).encode()).hexdigest()[:12]
    return [
        {"form": form, "question": f"q{i:03d}", "house": house, "left": left, "right": right}
        for i, (house, left, right) in enumerate(shuffled, 1)
    ]


def write_study(
    sheets: Sequence[str | Path],
    output_form: str | Path,
    output_key: str | Path,
    *,
    houses: Sequence[str],
    pairs: Sequence[Sequence[str]],
    seed: int,
) -> None:
    """Write the form (HTML) and its key (CSV, the rows of :func:`make_questions`).

    `sheets` are folders of :func:`.study_sheet.write_study_sheet`, in the order of `houses`.
    """
    questions = make_questions(houses, pairs, seed=seed)
    folders = dict(zip(houses, map(Path, sheets), strict=True))
    places: dict[Path, int] = {}  # index of each picture in the page's list of images
    asked = []
    for item in questions:
        folder = folders[item["house"]]
        photos = read_stage_json(folder / "sheet.json", "sheet")["photos"]
        names = ["plan.jpg", *photos, f"{item['left']}.jpg", f"{item['right']}.jpg"]
        plan, *shots, left, right = (places.setdefault(folder / n, len(places)) for n in names)
        question = {"id": item["question"], "plan": plan, "photos": shots}
        asked.append(question | {"left": left, "right": right})
    images = [base64.b64encode(path.read_bytes()).decode() for path in places]
    style, program = (
        _BODY.with_suffix(suffix).read_text(encoding="utf-8") for suffix in (".css", ".js")
    )
    page = html_page(
        _BODY,
        title="Which house fits better?",
        style=style,
        policy=f"default-src 'none'; img-src data:; style-src {source_hash(style)}; "
        f"script-src {source_hash(program)}",
        count=str(len(questions)),
        data=inline_json({"form": questions[0]["form"], "questions": asked, "images": images}),
        program=program,
    )
    write_text(output_form, page)
    write_csv(output_key, pd.DataFrame(questions))


#: Columns of an answer file, as the form writes them.
ANSWER_COLUMNS = ("form", "participant", "question", "choice", "seconds")
#: Share of choices for the first method of a pair in the paper's study (18 people, 20 houses).
PUBLISHED = {("synth", "crop"): 0.669, ("synth", "retrieve"): 0.694, ("synth", "naivesynth"): 0.728}
_MAX_BYTES = 1_000_000
_NAME = "[A-Za-z0-9_-]{1,40}"


def read_answers(path: str | Path, key: pd.DataFrame) -> pd.DataFrame:
    """Return the answers of one file, all columns as text; InputError for anything unexpected.

    Each line must have the form id of the `key` (columns form, question, house, left, right), name
    one of its questions, choose ``left`` or ``right``, and be that person's only answer to it.
    """
    file = Path(path)
    if file.is_file() and file.stat().st_size > _MAX_BYTES:
        raise InputError(f"at most {_MAX_BYTES} bytes", f"{file.stat().st_size}", file=file)
    head, *lines = read_text(file).splitlines() or [""]
    if head != ",".join(ANSWER_COLUMNS):
        raise InputError(f"the header {','.join(ANSWER_COLUMNS)}", repr(head[:100]), file=file)
    form, questions = key["form"][0], "|".join(key["question"])
    known = re.compile(rf"({form}),({_NAME}),({questions}),(left|right),([0-9]+(?:\.[0-9]+)?)")
    rows: dict[tuple[str, ...], tuple[str, ...]] = {}  # by participant and question
    for number, line in enumerate(lines, 2):
        match = known.fullmatch(line)
        if not match or match.group(2, 3) in rows:
            expected = (
                f"{form}, a name ({_NAME}), another question of the key, left or right, seconds"
            )
            raise InputError(f"{expected} in line {number}", repr(line[:100]), file=file)
        rows[match.group(2, 3)] = match.groups()
    return pd.DataFrame(rows.values(), columns=list(ANSWER_COLUMNS), dtype=object)


def preferences(
    key: pd.DataFrame, answers: pd.DataFrame, pairs: Sequence[Sequence[str]]
) -> pd.DataFrame:
    """Return how often the first method of each pair was chosen; skip pairs without answers.

    Columns ``method, other, participants, answers, chosen, share, low_95, high_95``. The 95 %
    interval is Wilson's, which stays within [0, 1] even near its ends and for few answers.
    """
    from scipy.stats import binomtest

    table = answers.merge(key, on=["form", "question"])
    winner = table["left"].where(table["choice"] == "left", table["right"])
    rows = []
    for method, other in pairs:
        asked = table["left"].isin([method, other]) & table["right"].isin([method, other])
        if not asked.any():
            continue
        count, total = int((winner[asked] == method).sum()), int(asked.sum())
        interval = binomtest(count, total).proportion_ci(method="wilson")
        people = table.loc[asked, "participant"].nunique()
        rows.append((method, other, people, total, count, count / total, *interval))
    head = ["method", "other", "participants", "answers", "chosen", "share", "low_95", "high_95"]
    return pd.DataFrame(rows, columns=head)


def study_result(
    key_file: str | Path,
    answer_files: Sequence[str | Path],
    output_csv: str | Path,
    output_text: str | Path,
    *,
    pairs: Sequence[Sequence[str]],
) -> pd.DataFrame:
    """Write the preferences as CSV and as text; return them.

    InputError if no file holds an answer. If a person answers the same question in two files, the
    file that comes later by name is refused.
    """
    key = pd.read_csv(key_file, dtype=str)
    answers, refused = _collected(key, sorted(map(Path, answer_files)))
    if answers.empty:
        why = "; ".join(refused) or f"{len(answer_files)} files without answers"
        raise InputError("files of answers in the folder study.answers", why, file=key_file)
    result = preferences(key, answers, pairs)
    names = zip(result["method"], result["other"], strict=True)
    result["published_share"] = [str(PUBLISHED.get(pair, "none")) for pair in names]
    write_csv(output_csv, result, float_format="%.4f")
    words = [
        f"{row.method} over {row.other}: {100 * row.share:.1f} % of {row.answers} choices by "
        f"{row.participants} people, 95 % interval {100 * row.low_95:.1f} to "
        f"{100 * row.high_95:.1f} % (paper: {row.published_share})"
        for row in result.itertuples()
    ]
    words += [
        "\nThe interval (Wilson) takes every choice as independent; those of one person or one "
        "house are not quite.",
        f"{len(answer_files) - len(refused)} of {len(answer_files)} files counted.",
        *(f"refused: {line}" for line in refused),
    ]
    write_text(output_text, "\n".join(words) + "\n")
    return result


def _collected(key: pd.DataFrame, files: Sequence[Path]) -> tuple[pd.DataFrame, list[str]]:
    """Return the answers of all valid files, and a line for each refused file with the reason."""
    answers = pd.DataFrame(columns=list(ANSWER_COLUMNS))
    refused = []
    for path in files:
        try:
            both = pd.concat([answers, read_answers(path, key)], ignore_index=True)
            twice = both[both.duplicated(["participant", "question"])]
            if len(twice):
                found = f"{twice['participant'].iloc[0]} again, {twice['question'].iloc[0]}"
                raise InputError("participants that no other file has", found, file=path)
            answers = both
        except InputError as error:
            refused.append(str(error))
            logging.getLogger("plan2scene").warning("refused: %s", error)
    return answers, refused
