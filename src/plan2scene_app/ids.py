"""Make ids from the names that people give to houses and rooms."""

from __future__ import annotations

import re
import unicodedata

from plan2scene.plans.room_names import WRITTEN


def fit_id(name: str, otherwise: str) -> str:
    """Return an id made from a name, without accents; `otherwise` for a name in another script."""
    plain = unicodedata.normalize("NFKD", name.translate(WRITTEN))
    plain = plain.encode("ascii", "ignore").decode()
    name_id = re.sub(r"[^A-Za-z0-9_.-]+", "_", plain).lstrip("._-").rstrip("_")[:60]
    lost = any(map(str.isalpha, name)) and not re.search("[A-Za-z]", name_id)
    return otherwise if lost or not name_id else name_id


def free_id(name: str, taken: set[str], otherwise: str = "room") -> str:
    """Return a lower-case id made from a name and add it to `taken`; number it if it is taken."""
    stem = re.sub(r"[^a-z0-9]+", "_", fit_id(name, otherwise).lower()).strip("_")[:40] or otherwise
    name_id, number = stem, 1
    while name_id in taken:
        number += 1
        name_id = f"{stem}_{number}"
    taken.add(name_id)
    return name_id
