"""Photos that are hidden at a drop fraction: from the data set's list, or a seeded random draw."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

from plan2scene.errors import InputError
from plan2scene.io import read_json

SWEEP_DROPS = tuple(f"{tenth / 10:.1f}" for tenth in range(11))  #: Fractions of the sweep


def hidden_photos(
    listed: Mapping[str, Collection[str]] | None,
    drop: str,
    photos: Sequence[str],
    *,
    seed: int,
    house_id: str,
) -> list[str]:
    """Return those of a house's `photos` that are hidden at fraction `drop` (``"0.3"``), sorted.

    `listed` is the data set's ``unobserved_photos.json``, from fraction to hidden photos of all
    houses (sets are faster than lists). Between two of its fractions (Rent3D++ has steps of 0.2),
    the photos of the smaller one are hidden, and a share of those that the larger one adds, in a
    seeded order. Fraction 0.0 hides no photo, 1.0 all. Without `listed`, that share of all the
    house's photos is hidden. Photos hidden at 0.2 are also hidden at 0.4.
    """
    hidden_at = {1.0: set(photos)}
    hidden_at |= {
        float(name): hidden_at[1.0].intersection(of) for name, of in (listed or {}).items()
    }
    hidden_at[0.0] = set()
    fraction = float(drop)
    low = max(value for value in hidden_at if value <= fraction)
    high = min(value for value in hidden_at if value >= fraction)
    if low == high:
        return sorted(hidden_at[low])
    from plan2scene.seeds import generator

    more = sorted(hidden_at[high] - hidden_at[low])
    count = round((fraction - low) / (high - low) * len(more))
    interval = () if listed is None else (f"{low:.1f}",)
    order = generator(seed, "hidden_photos", house_id, *interval).permutation(len(more))
    return sorted(hidden_at[low] | {more[i] for i in order[:count]})


def read_unobserved(path: str | Path) -> dict[str, list[str]]:
    """Return the photos to hide at each drop fraction: ``{"0.0": [], "0.6": [names], ...}``.

    Keys are written with one decimal, whatever the file has (``0.60`` becomes ``0.6``).
    """
    table = read_json(path)
    if not isinstance(table, dict):
        raise InputError("an object of drop fractions", type(table).__name__, file=path)
    photos_by_drop: dict[str, list[str]] = {}
    for key, names in table.items():
        try:
            fraction = float(key)
        except ValueError:
            fraction = -1.0
        if not 0.0 <= fraction <= 1.0:
            raise InputError("drop fractions from 0 to 1", repr(key), file=path)
        if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
            raise InputError(f"a list of photo names at {key}", repr(names)[:60], file=path)
        photos_by_drop[f"{fraction:.1f}"] = names
    return photos_by_drop
