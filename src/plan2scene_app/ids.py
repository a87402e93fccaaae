"""Ids made of the names that people give."""

from __future__ import annotations

import re
import unicodedata

from plan2scene.plans.room_names import WRITTEN


def fit_id(name: str, otherwise: str) -> str:
    """Return a name as an id: letters without their accents; `otherwise` for another script."""
    plain = unicodedata.normalize("NFKD", name.translate(WRITTEN))
    plain = plain.encode("ascii", "ignore").decode()
    made = re.sub(r"[^A-Za-z0-9_.-]+", "_", plain).lstrip("._-").rstrip("_")[:60]
    lost = any(map(str.isalpha, name)) and not re.search("[A-Za-z]", made)
    return otherwise if lost or not made else made


def free_id(name: str, taken: set[str], otherwise: str = "room") -> str:
    """Return an id made of a name that is not taken yet, and take it: lower case, numbered."""
    stem = re.sub(r"[^a-z0-9]+", "_", fit_id(name, otherwise).lower()).strip("_")[:40] or otherwise
    name_id, number = stem, 1
    while name_id in taken:
        number += 1
        name_id = f"{stem}_{number}"
    taken.add(name_id)
    return name_id
