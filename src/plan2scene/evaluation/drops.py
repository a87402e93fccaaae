"""Photos hidden at any drop fraction, also those that a data set's list leaves out."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from plan2scene.datasets import read_unobserved
from plan2scene.datasets.house_table import hidden_photo_names
from plan2scene.seeds import generator

#: Fractions of the sweep.
SWEEP_DROPS = tuple(f"{tenth / 10:.1f}" for tenth in range(11))


def hidden_at(path: Path, drop: str, photos: Sequence[str], *, seed: int, house: str) -> list[str]:
    """Return the photos of a house that are hidden at drop fraction `drop` (``"0.3"``), sorted.

    As :func:`plan2scene.datasets.house_table.hidden_photo_names` where the data set's list has the
    fraction or there is none. A fraction that the list leaves out (Rent3D++ goes in steps of
    0.2) hides what the next smaller one hides and, in a seeded order, a share of what the next
    larger one hides beyond it: none of them at 0.0, all photos at 1.0.
    """
    if not path.is_file():
        return hidden_photo_names(path, drop, photos, seed=seed, house=house)
    table = read_unobserved(path)
    if drop in table:
        return hidden_photo_names(path, drop, photos, seed=seed, house=house)
    own = set(photos)
    known = {0.0: set[str](), 1.0: own}
    known |= {float(name): own & set(names) for name, names in table.items()}
    fraction = float(drop)
    low = max(value for value in known if value <= fraction)
    high = min(value for value in known if value >= fraction)
    if low == high:
        return sorted(known[low])
    more = sorted(known[high] - known[low])
    count = round((fraction - low) / (high - low) * len(more))
    order = generator(seed, "hidden_photos", house, f"{low:.1f}").permutation(len(more))
    return sorted(known[low] | {more[i] for i in order[:count]})
