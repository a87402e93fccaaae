"""Names of rooms in several languages, and the room type that each name means."""

from __future__ import annotations

import csv
import re
import unicodedata
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

from plan2scene.house import ROOM_TYPES


def _read_stems() -> dict[tuple[str, str], list[str]]:
    """Return the stems in room_names.csv by room type and use, in the file's order."""
    stems: dict[tuple[str, str], list[str]] = {}
    text = Path(__file__).with_name("room_names.csv").read_text(encoding="utf-8")
    for row in csv.DictReader(text.splitlines()):
        stems.setdefault((row["type"], row["use"]), []).extend(row["stems"].split())
    return stems


#: Stems of words (lower case, no accents; `_` for a space) by room type, and by use where it counts
#: (garages, laundries and utility rooms). The first type with a stem in a name decides: "bathroom"
#: is found before "room" could be. Indoor rooms of a use that has no type (garage, office) are
#: Unknown.
_STEMS = _read_stems()
_GARAGE, _LAUNDRY = _STEMS["Unknown", "garage"], _STEMS["Unknown", "laundry"]
#: Names that match only as a whole: "zimmer" alone is a bedroom (German); abbreviations.
_WHOLE = {"zimmer": "Bedroom", "w i cl": "Closet", "k": "Kitchen", "bijkeuken": "Unknown"}
_WHOLE |= dict.fromkeys(("c", "cl", "st"), "Closet") | {"przedpokoj": "Corridor"}
_WHOLE |= dict.fromkeys(("obyvaci pokoj", "pokoj dzienny", "dnevna soba"), "Reception")
_WHOLE |= {"dnevni prostor": "Reception", "baie": "Bathroom", "szoba": "Bedroom"}
_TYPES = {name.lower(): name for name in ROOM_TYPES} | _WHOLE


#: Latin letters that Unicode does not decompose into a letter and an accent.
WRITTEN = str.maketrans(
    {"æ": "ae", "œ": "oe", "ø": "o", "ł": "l", "đ": "d", "ð": "d", "þ": "th", "ß": "ss", "ı": "i"}
    | {"Æ": "Ae", "Œ": "Oe", "Ø": "O", "Ł": "L", "Đ": "D", "Ð": "D", "Þ": "Th"}
)


@lru_cache(maxsize=1024)
def room_types(name: str) -> tuple[str, ...]:
    """Return the room types that a name means, in the order of its words; empty for none.

    A name may join several rooms ("Living / Kitchen"): each part is read alone. A room of a use
    that has no type ("Garage") is Unknown.
    """
    types: list[str] = []
    for part in re.split(r"(?<!\b[wWсС])[/+&,;|]| und | and | et | y | e | en ", f"{name} "):
        kind = _type_of(part)
        if kind is not None and kind not in types:
            types.append(kind)
    return tuple(kind for kind in types if kind != "Unknown") or tuple(types)


def is_garage(name: str) -> bool:
    """Return whether a name means a garage, and no room of another type."""
    return room_types(name) == ("Unknown",) and _has_stem(_words_of(name), _GARAGE)


def has_bare_floor(types: Sequence[str], name: str) -> bool:
    """Return whether a room is only a kitchen, laundry or entrance: few of them have a carpet."""
    laundry = room_types(name) == ("Unknown",) and _has_stem(_words_of(name), _LAUNDRY)
    return laundry or tuple(types) in (("Kitchen",), ("Entrance",))


def _type_of(text: str) -> str | None:
    """Return the room type of one name."""
    words = _words_of(text)
    plain = " ".join(words)
    if plain in _TYPES:
        return None if plain == "unknown" else _TYPES[plain]
    return next((kind for (kind, _), stems in _STEMS.items() if _has_stem(words, stems)), None)


def _words_of(text: str) -> list[str]:
    """Return the words of a name, lower case and without accents."""
    plain = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", text).translate(WRITTEN)
    plain = unicodedata.normalize("NFKC", _without_accents(plain)).lower()
    plain = re.sub(r"(?<=\b\w)[.](?=\w\b)|['’`´]", "", plain)  # "W.I.R.", "L'DRY"
    return re.sub(r"[\W\d_]+", " ", plain).split()


def _has_stem(words: Sequence[str], stems: Sequence[str]) -> bool:
    """Return whether the words of a name contain one of the `stems`."""
    joined = f"_{'_'.join(words)}"
    return any(
        ("_" in stem and f"_{stem}" in joined) or any(_is(word, stem) for word in words)
        for stem in stems
    )


def _without_accents(text: str) -> str:
    """Return a text without accents of Latin and Greek letters; other scripts keep their marks."""
    parts = []
    for letter in text:
        plain = unicodedata.normalize("NFKD", letter)
        bare = plain[:1].isascii() or "α" <= plain[:1].lower() <= "ω"
        parts.append(plain[0] if bare and len(plain) > 1 else letter)
    return "".join(parts)


def _is(word: str, stem: str) -> bool:
    """Return whether a word is a stem, its plural, or (long stems) begins or ends with it.

    In scripts without spaces it may be anywhere in a word; Hebrew and Russian words begin with it.
    """
    if not stem.isascii():
        return stem in word if stem > "\u3000" else word.startswith(stem)
    if word in (stem, f"{stem}s", f"{stem}es", f"{stem}n"):
        return True
    return len(stem) >= 5 and (word.startswith(stem) or word.endswith(stem))
