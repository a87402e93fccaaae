"""Lengths and areas as plans write them: ``3.20 m``, ``3200``, ``12'6"``, ``14,5 m2``, ``3x4``."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from statistics import median

_FOOT = 0.3048
_MAT = 1.62  #: m2 of a tatami mat in Japanese advertisements
_NUMBER = r"\d{1,5}(?:[.,]\d{1,3})?"
_AREA = re.compile(
    rf"({_NUMBER})\s*(m\s?[2²]|m\^2|㎡|qm|mq|sq\.?\s?m|sq\.?\s?ft|sq\.?\s?feet"
    r"|ft\.?\s?[2²]|sf|м\s?[2²]|кв\.?\s?м|[帖畳])(?![a-z])",
    re.IGNORECASE,
)
#: A unit before its number: ``mq 12,50``.
_UNIT_FIRST = re.compile(
    rf"(?<!\d)(?<!\d\s)\b(mq|m[2²])(?:\.\s*|\s+)({_NUMBER})(?!\s*[\d.,x×])", re.IGNORECASE
)
_FEET = re.compile(
    r"""^(\d{1,3})\s*(?:'|’|′|`|ft\.?|feet)\s*-?\s*(?:(\d{1,2}(?:[.,]\d)?)\s*(?:"|''|”|″|“|in\.?)?)?$""",
    re.IGNORECASE,
)
_METRIC = re.compile(rf"^({_NUMBER})\s*(mm|cm|m)?\.?$", re.IGNORECASE)
_CROSS = re.compile(r"(?<=[\d'\"m”″’ ])\s*(?:[x×X*]|\bby\b)\s*(?=\d)", re.IGNORECASE)
#: A length within a text; two of them; what is written beside them; a part in brackets.
_LENGTH = (
    r"""(?:\d{1,3}\s*(?:'|’|′|`|ft\.?|feet)\s*-?\s*(?:\d{1,2}(?:[.,]\d)?\s*(?:"|''|”|″|“|in\.?)?)?"""
    rf"|{_NUMBER}\s*(?:mm|cm|m)?)(?![\d.,]*\d)"
)
_PAIR = re.compile(rf"(?<![\d.,])~?\s*{_LENGTH}\s*(?:[x×X*]|\bby\b)\s*{_LENGTH}", re.IGNORECASE)
_NOTES = re.compile(
    r"\b(?:max(?:imum)?|min(?:imum)?|approx(?:imately)?|overall|at (?:the )?widest(?: point)?"
    r"|into (?:the )?(?:bay|recess|alcoves?|wardrobes?))\b\.?",
    re.IGNORECASE,
)
_BRACKETS = re.compile(r"[(\[]([^)\]]*)[)\]]?")
_SMALL = re.compile(r"^\d{1,2}(?:[.,]\d{1,2})?$")
_HALL = 6.5  #: m; rooms of a home have a smaller median side
#: Possible lengths (metres) and areas (m2) in homes.
_LENGTHS, _AREAS = (0.3, 60.0), (0.5, 600.0)


def read_areas(text: str) -> list[tuple[float, float]]:
    """Return each area in a text in m2, and the value in m2 of one in its last digit."""
    areas = []
    for number, unit in _AREA.findall(_UNIT_FIRST.sub(r"\2 \1", text)):
        square = _MAT if unit in "帖畳" else _FOOT**2 if "f" in unit.lower() else 1.0
        value, digit = (square * part for part in _value(number))
        if _AREAS[0] <= value <= _AREAS[1]:
            areas.append((value, digit))
    return areas


def read_length(text: str) -> list[float]:
    """Return the lengths in metres that a text may mean; several where it gives no unit."""
    plain = text.strip().strip("()[]")
    feet = _FEET.match(plain)
    if feet is not None:
        inches = _value(feet[2])[0] if feet[2] else 0.0
        return _possible([(int(feet[1]) + inches / 12) * _FOOT]) if inches < 12 else []
    metric = _METRIC.match(plain)
    if metric is None:
        return []
    value, digit = _value(metric[1])
    unit = (metric[2] or "").lower()
    if unit:
        return _possible([value * {"mm": 0.001, "cm": 0.01, "m": 1.0}[unit]])
    if digit < 1:
        return _possible([value, value / 100])
    if value < 30:  # the number of a room or a storey
        return []
    return _possible([value / 1000, value / 100])


def sides_in_feet(texts: Iterable[str]) -> bool:
    """Return whether sides without a unit are decimal feet: in metres they would be too large."""
    plain = [pairs for text in texts if in_two_units(pairs := read_sides(text))]
    sides = [side for pairs in plain for side in pairs[0]]
    return bool(sides) and median(sides) > _HALL


def in_two_units(pairs: Sequence[tuple[float, float]]) -> bool:
    """Return whether `pairs` of :func:`read_sides` are one reading in metres and one in feet."""
    return len(pairs) == 2 and abs(pairs[1][0] / pairs[0][0] - _FOOT) < 1e-6


def read_sides(text: str) -> list[tuple[float, float]]:
    """Return the pairs of sides of a room, in metres, that a text may mean.

    Small numbers without a unit give two pairs: read as metres, then as decimal feet. What stands
    in brackets repeats the sides in another unit; it is read only if nothing else gives sides.
    """
    plain = _NOTES.sub(" ", text)
    for part in (_BRACKETS.sub(" ", plain), *_BRACKETS.findall(plain)):
        pair = _PAIR.search(part)
        sides = _sides_of(pair[0]) if pair else []
        if sides:
            return sides
    return []


def without_measures(text: str) -> str:
    """Return a text without its areas and sides: the name of a room beside them."""
    plain = _UNIT_FIRST.sub(r"\2 \1", _NOTES.sub(" ", text))
    plain = _BRACKETS.sub(lambda part: " " if re.search(r"\d", part[1]) else part[0], plain)
    return " ".join(_PAIR.sub(" ", _AREA.sub(" ", plain)).split()).strip(" ,;:~-")


def _sides_of(text: str) -> list[tuple[float, float]]:
    plain = re.sub(r"\s*(mm|cm|m|ft)\.?$", r"\1", text.strip(" ~"), flags=re.IGNORECASE)
    parts = _CROSS.split(plain)
    if len(parts) != 2:
        return []
    unit = re.search(r"(mm|cm|m)$", parts[1], re.IGNORECASE)
    if unit and not re.search(r"m$", parts[0].strip(), re.IGNORECASE):
        parts[0] += unit[1]
    if all(_SMALL.match(part.strip()) for part in parts):  # metres or decimal feet
        numbers = [_value(part.strip())[0] for part in parts]
        pairs = ([unit * number for number in numbers] for unit in (1.0, _FOOT))
        return [(a, b) for a, b in pairs if _possible([a, b]) == [a, b]]
    first, second = (read_length(part) for part in parts)
    if len(first) == len(second):
        return list(zip(first, second, strict=True))
    return [(a, b) for a in first for b in second if 0.2 < a / b < 5]


def _value(text: str) -> tuple[float, float]:
    """Return a number, and the value of one in its last digit."""
    whole, _, digits = text.replace(",", ".").partition(".")
    return float(f"{whole}.{digits or 0}"), 10.0 ** -len(digits)


def _possible(lengths: list[float]) -> list[float]:
    """Return those of the lengths that are possible in a home."""
    return [length for length in lengths if _LENGTHS[0] <= length <= _LENGTHS[1]]
