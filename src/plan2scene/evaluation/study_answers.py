"""Answers of the user study: which of two methods is preferred, how often, how sure that is.

Answer files come from strangers. A file is taken whole or not at all; the report names each one
that is refused and why.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from plan2scene.errors import InputError
from plan2scene.io import read_text, write_csv, write_text

#: Columns of an answer file, as the form writes them.
ANSWER_COLUMNS = ("form", "participant", "question", "choice", "seconds")
#: Share of choices for Synth in the paper's study (18 people, 20 houses), by the other method.
PUBLISHED = {("synth", "crop"): 0.669, ("synth", "retrieve"): 0.694, ("synth", "naivesynth"): 0.728}
_MAX_BYTES = 1_000_000
_NAME = "[A-Za-z0-9_-]{1,40}"


def read_answers(path: str | Path, key: pd.DataFrame) -> pd.DataFrame:
    """Return the answers of one file, all columns text; InputError for anything unexpected.

    Each line must be of the form of the `key` (columns form, question, house, left, right), name a
    question of it, choose ``left`` or ``right`` and be that person's only answer to it.
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
        found = known.fullmatch(line)
        if not found or found.group(2, 3) in rows:
            expected = (
                f"{form}, a name ({_NAME}), another question of the key, left or right, seconds"
            )
            raise InputError(f"{expected} in line {number}", repr(line[:100]), file=file)
        rows[found.group(2, 3)] = found.groups()
    return pd.DataFrame(rows.values(), columns=list(ANSWER_COLUMNS), dtype=object)


def preferences(
    key: pd.DataFrame, answers: pd.DataFrame, pairs: Sequence[Sequence[str]]
) -> pd.DataFrame:
    """Return how often the first method of each pair that has answers was chosen.

    Columns ``method, other, participants, answers, chosen, share, low_95, high_95``; the interval
    is Wilson's, within [0, 1] also near its ends and for few answers.
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

    InputError when no file holds an answer. A person who appears in two files counts once per
    question: the later file, by name, is refused.
    """
    key = pd.read_csv(key_file, dtype=str)
    answers, refused = _collected(key, sorted(map(Path, answer_files)))
    if answers.empty:
        why = "; ".join(refused) or f"{len(answer_files)} files without answers"
        raise InputError("answers to the study's form", why, file=key_file)
    found = preferences(key, answers, pairs)
    names = zip(found["method"], found["other"], strict=True)
    found["published_share"] = [str(PUBLISHED.get(pair, "none")) for pair in names]
    write_csv(output_csv, found, float_format="%.4f")
    words = [
        f"{row.method} over {row.other}: {100 * row.share:.1f} % of {row.answers} choices by "
        f"{row.participants} people, 95 % interval {100 * row.low_95:.1f} to "
        f"{100 * row.high_95:.1f} % (paper: {row.published_share})"
        for row in found.itertuples()
    ]
    words += [
        "\nThe interval (Wilson) takes every choice as independent; those of one person or one "
        "house are not quite.",
        f"{len(answer_files) - len(refused)} of {len(answer_files)} files counted.",
        *(f"refused: {line}" for line in refused),
    ]
    write_text(output_text, "\n".join(words) + "\n")
    return found


def _collected(key: pd.DataFrame, files: Sequence[Path]) -> tuple[pd.DataFrame, list[str]]:
    """Return the answers of all good files, and why each other one is refused."""
    answers = pd.DataFrame(columns=list(ANSWER_COLUMNS))
    refused = []
    for path in files:
        try:
            both = pd.concat([answers, read_answers(path, key)], ignore_index=True)
            twice = both[both.duplicated(["participant", "question"])]
            if len(twice):
                found = f"{twice['participant'].iloc[0]} again, {twice['question'].iloc[0]}"
                raise InputError("people of no other file", found, file=path)
            answers = both
        except InputError as error:
            refused.append(str(error))
            logging.getLogger("plan2scene").warning("refused: %s", error)
    return answers, refused
