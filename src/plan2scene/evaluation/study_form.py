"""The user study's form: forced choices between two renders, in one offline HTML file.

As in the paper (section 5.4): two methods' renders from above without ceilings, given the plan
and the photos; both the order of the questions and which method is left are drawn by seed. The
form does not say which is which: that is in the key, a file of its own.
"""

from __future__ import annotations

import base64
import csv
import hashlib
import html
import json
from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from string import Template

from plan2scene.io import atomic_path, read_json
from plan2scene.seeds import generator

_TEMPLATE = Path(__file__).with_name("study_form.html")


@dataclass(frozen=True)
class Question:
    """One choice: a house by two methods. `form` names the form that it belongs to."""

    form: str
    question: str
    house: str
    left: str
    right: str


#: Columns of the key.
KEY_COLUMNS = tuple(field.name for field in fields(Question))


def study_houses(houses: Sequence[str], count: int, *, seed: int) -> list[str]:
    """Return `count` of the houses in a seeded order; all where there are fewer."""
    order = generator(seed, "study", "houses").permutation(len(houses))
    return [sorted(houses)[i] for i in order[:count]]


def make_questions(
    houses: Sequence[str], pairs: Sequence[Sequence[str]], *, seed: int
) -> list[Question]:
    """Return a question per house and pair of methods, shuffled by seed, sides too.

    Every pair has either method left in half of its questions, one more or less.
    """
    drawn: list[tuple[str, str, str]] = []
    for first, second in pairs:
        rng = generator(seed, "study", "sides", first, second)
        flip = rng.permutation(len(houses)) % 2 == 1
        drawn += [
            (house, second, first) if flipped else (house, first, second)
            for house, flipped in zip(houses, flip, strict=True)
        ]
    order = generator(seed, "study", "order").permutation(len(drawn))
    shuffled = [drawn[i] for i in order]
    form = hashlib.sha256(json.dumps(shuffled).encode()).hexdigest()[:12]
    return [Question(form, f"q{i:03d}", *item) for i, item in enumerate(shuffled, 1)]


def write_study(
    sheets: Sequence[str | Path],
    output_form: str | Path,
    output_key: str | Path,
    *,
    houses: Sequence[str],
    pairs: Sequence[Sequence[str]],
    seed: int,
) -> None:
    """Write the form (HTML) and its key (CSV with the columns of :data:`KEY_COLUMNS`).

    Parameters
    ----------
    sheets : sequence of path
        Folders of :func:`plan2scene.evaluation.study_sheet.write_study_sheet`, one per house, in
        the order of `houses`.
    pairs : sequence of two methods
    """
    questions = make_questions(houses, pairs, seed=seed)
    folders = dict(zip(houses, map(Path, sheets), strict=True))
    images: list[str] = []
    places: dict[Path, int] = {}

    def place(path: Path) -> int:
        if path not in places:
            places[path] = len(images)
            images.append(base64.b64encode(path.read_bytes()).decode())
        return places[path]

    asked = []
    for item in questions:
        folder = folders[item.house]
        photos = read_json(folder / "sheet.json")["photos"]
        asked.append(
            {
                "id": item.question,
                "plan": place(folder / "plan.jpg"),
                "photos": [place(folder / name) for name in photos],
                "left": place(folder / f"{item.left}.jpg"),
                "right": place(folder / f"{item.right}.jpg"),
            }
        )
    data = json.dumps({"form": questions[0].form, "questions": asked, "images": images})
    page = Template(_TEMPLATE.read_text(encoding="utf-8")).substitute(
        count=html.escape(str(len(questions))), data=data.replace("<", "\\u003c")
    )
    with atomic_path(output_form) as temporary:
        temporary.write_text(page, encoding="utf-8")
    with atomic_path(output_key) as temporary, temporary.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(KEY_COLUMNS)
        writer.writerows(astuple(item) for item in questions)
