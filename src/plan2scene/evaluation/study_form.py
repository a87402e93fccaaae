"""The user study's form: forced choices between two renders, in one offline HTML file.

As in the paper (section 6.5): two methods' renders from above without ceilings, given the plan
and the photos; both the order of the questions and which method is left are drawn by seed. The
form does not say which is which: that is in the key, a file of its own.
"""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Sequence
from pathlib import Path

from plan2scene.html_page import html_page, inline_json, source_hash
from plan2scene.io import read_json, write_csv, write_text
from plan2scene.seeds import generator

_BODY = Path(__file__).with_name("study_form.html")


def study_houses(houses: Sequence[str], count: int, *, seed: int) -> list[str]:
    """Return `count` of the houses in a seeded order; all where there are fewer."""
    order = generator(seed, "study", "houses").permutation(len(houses))
    return [sorted(houses)[i] for i in order[:count]]


def make_questions(
    houses: Sequence[str], pairs: Sequence[Sequence[str]], *, seed: int
) -> list[dict[str, str]]:
    """Return the key's rows: a question per house and pair of methods, shuffled, sides too.

    Every pair has either method left in half of its questions, one more or less. ``form`` names
    the form that a question belongs to.
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
    import pandas as pd

    questions = make_questions(houses, pairs, seed=seed)
    folders = dict(zip(houses, map(Path, sheets), strict=True))
    places: dict[Path, int] = {}  # of each picture in the page's list
    asked = []
    for item in questions:
        folder = folders[item["house"]]
        photos = read_json(folder / "sheet.json")["photos"]
        names = ["plan.jpg", *photos, f"{item['left']}.jpg", f"{item['right']}.jpg"]
        plan, *shown, left, right = (places.setdefault(folder / n, len(places)) for n in names)
        question = {"id": item["question"], "plan": plan, "photos": shown}
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
