"""Answers of the user study: which of two methods is preferred, how often, how sure that is.

Answer files come from strangers. A file is taken whole or not at all; the report names each one
that is refused and why.
"""

from __future__ import annotations

import csv
import io
import logging
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from plan2scene.errors import InputError
from plan2scene.evaluation.study_form import KEY_COLUMNS, Question
from plan2scene.io import atomic_path, read_text

#: Columns of an answer file, as the form writes them.
ANSWER_COLUMNS = ("form", "participant", "question", "choice", "seconds")
#: Share of choices for Synth in the paper's study (18 people, 20 houses), by the other method.
PUBLISHED = {
    ("synth", "crop"): 0.669,
    ("synth", "retrieve"): 0.694,
    ("synth", "naivesynth"): 0.728,
}
#: Two-sided 95 % of the normal distribution.
Z_95 = 1.959963984540054
_MAX_BYTES = 1_000_000
_PARTICIPANT = re.compile(r"[A-Za-z0-9_-]{1,40}")


@dataclass(frozen=True)
class Answer:
    """One person's choice in one question: "left" or "right"."""

    participant: str
    question: str
    choice: str


def wilson_interval(count: int, total: int, z: float = Z_95) -> tuple[float, float]:
    """Return the Wilson score interval of a share count / total (Wilson 1927).

    Within [0, 1] also near its ends and for few answers. ValueError without any.
    """
    if total < 1 or not 0 <= count <= total:
        raise ValueError(f"expected 0 <= count <= total and a total, found {count} of {total}")
    share = count / total
    centre = (share + z**2 / (2 * total)) / (1 + z**2 / total)
    spread = math.sqrt(share * (1 - share) / total + z**2 / (4 * total**2))
    half = z / (1 + z**2 / total) * spread
    return max(0.0, centre - half), min(1.0, centre + half)


def read_key(path: str | Path) -> dict[str, Question]:
    """Return the questions of a key by their id."""
    rows = list(csv.DictReader(io.StringIO(read_text(path))))
    if not rows or tuple(rows[0]) != KEY_COLUMNS:
        raise InputError(f"a key with {','.join(KEY_COLUMNS)}", "another table", file=path)
    return {row["question"]: Question(**row) for row in rows}


def read_answers(path: str | Path, questions: Mapping[str, Question]) -> list[Answer]:
    """Return the answers of one file; InputError, naming the line, for anything unexpected.

    Each row must be of this form, name a question of its key, choose ``left`` or ``right`` and
    be that person's only answer to it.
    """
    file = Path(path)
    if file.is_file() and file.stat().st_size > _MAX_BYTES:
        raise InputError(f"at most {_MAX_BYTES} bytes", f"{file.stat().st_size}", file=file)
    text = read_text(file)
    try:
        rows = list(csv.reader(io.StringIO(text), strict=True))
    except csv.Error as error:
        raise InputError("a CSV file", str(error), file=file) from None
    if not rows or tuple(rows[0]) != ANSWER_COLUMNS:
        found = ",".join(rows[0])[:100] if rows else "an empty file"
        raise InputError(f"the header {','.join(ANSWER_COLUMNS)}", repr(found), file=file)
    forms = {question.form for question in questions.values()}
    answers: dict[tuple[str, str], Answer] = {}
    for number, row in enumerate(rows[1:], 2):
        answer = _answer(row, number, questions, forms, file)
        key = (answer.participant, answer.question)
        if key in answers:
            raise InputError(
                f"one answer of {answer.participant} to {answer.question}",
                f"another in line {number}",
                file=file,
            )
        answers[key] = answer
    return list(answers.values())


def _answer(
    row: Sequence[str],
    number: int,
    questions: Mapping[str, Question],
    forms: set[str],
    file: Path,
) -> Answer:
    """Return the answer of a row."""
    where = f"in line {number}"
    if len(row) != len(ANSWER_COLUMNS):
        raise InputError(f"{len(ANSWER_COLUMNS)} columns {where}", str(len(row)), file=file)
    form, participant, question, choice, seconds = row
    if form not in forms:
        raise InputError(f"form {sorted(forms)[0]} {where}", repr(form[:40]), file=file)
    if not _PARTICIPANT.fullmatch(participant):
        raise InputError(
            f"a participant of letters, digits, '_', '-' {where}", repr(participant[:40]), file=file
        )
    if question not in questions:
        raise InputError(f"a question of the key {where}", repr(question[:40]), file=file)
    if choice not in ("left", "right"):
        raise InputError(f"left or right {where}", repr(choice[:40]), file=file)
    try:
        valid = 0 <= float(seconds) < math.inf
    except ValueError:
        valid = False
    if not valid:
        raise InputError(f"seconds of 0 or more {where}", repr(seconds[:40]), file=file)
    return Answer(participant, question, choice)


@dataclass(frozen=True)
class Preference:
    """How often `method` was chosen over `other`; the interval is Wilson's of 95 %."""

    method: str
    other: str
    participants: int
    answers: int
    chosen: int
    share: float
    low: float
    high: float


def preferences(
    questions: Mapping[str, Question],
    answers: Iterable[Answer],
    pairs: Sequence[Sequence[str]],
) -> list[Preference]:
    """Return the preference for the first method of each pair that has answers."""
    chosen: dict[tuple[str, str], list[tuple[str, str]]] = {}
    for answer in answers:
        question = questions[answer.question]
        sides = {"left": question.left, "right": question.right}
        loser = sides["right" if answer.choice == "left" else "left"]
        record = (answer.participant, sides[answer.choice])
        chosen.setdefault(_unordered(sides[answer.choice], loser), []).append(record)
    found = []
    for method, other in pairs:
        records = chosen.get(_unordered(method, other), [])
        if not records:
            continue
        count = sum(winner == method for _, winner in records)
        low, high = wilson_interval(count, len(records))
        people = len({participant for participant, _ in records})
        share = count / len(records)
        found.append(Preference(method, other, people, len(records), count, share, low, high))
    return found


def _unordered(a: str, b: str) -> tuple[str, str]:
    """Return two names in a fixed order."""
    return (a, b) if a < b else (b, a)


def study_result(
    key: str | Path,
    answer_files: Sequence[str | Path],
    output_csv: str | Path,
    output_text: str | Path,
    *,
    pairs: Sequence[Sequence[str]],
) -> list[Preference]:
    """Write the preferences as CSV and as text; return them.

    InputError when no file holds an answer. A person who appears in two files counts once per
    question: the later file, by name, is refused.
    """
    questions = read_key(key)
    answers: dict[tuple[str, str], Answer] = {}
    refused: list[str] = []
    for path in sorted(map(Path, answer_files)):
        try:
            mine = {(a.participant, a.question): a for a in read_answers(path, questions)}
            if twice := sorted(set(mine) & set(answers)):
                person, question = twice[0]
                raise InputError(
                    "people of no other file", f"{person} again, {question}", file=path
                )
        except InputError as error:
            refused.append(str(error))
            logging.getLogger("plan2scene").warning("refused: %s", error)
            continue
        answers.update(mine)
    if not answers:
        why = "; ".join(refused) or f"{len(answer_files)} files without answers"
        raise InputError("answers to the study's form", why, file=key)
    found = preferences(questions, answers.values(), pairs)
    _write(found, output_csv, output_text, refused, len(answer_files))
    return found


def _write(
    found: Sequence[Preference],
    output_csv: str | Path,
    output_text: str | Path,
    refused: Sequence[str],
    files: int,
) -> None:
    """Write the table, and the same in words with the files that were refused."""
    head = "method,other,participants,answers,chosen,share,low_95,high_95,published_share"
    lines, words = [head], []
    for row in found:
        published = PUBLISHED.get((row.method, row.other))
        known = "none" if published is None else f"{published:g}"
        lines.append(
            f"{row.method},{row.other},{row.participants},{row.answers},{row.chosen},"
            f"{row.share:.4f},{row.low:.4f},{row.high:.4f},{known}"
        )
        words.append(
            f"{row.method} over {row.other}: {100 * row.share:.1f} % of {row.answers} choices by "
            f"{row.participants} people, 95 % interval {100 * row.low:.1f} to "
            f"{100 * row.high:.1f} %" + ("" if published is None else f" (paper: {known})")
        )
    words.append(
        "\nThe interval (Wilson) takes every choice as independent; those of one person or one "
        "house are not quite."
    )
    words.append(f"{files - len(refused)} of {files} files counted.")
    words += [f"refused: {line}" for line in refused]
    for path, text in ((output_csv, lines), (output_text, words)):
        with atomic_path(path) as temporary:
            temporary.write_text("\n".join(text) + "\n", encoding="utf-8")
