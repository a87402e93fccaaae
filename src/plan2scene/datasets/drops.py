"""Photos that count as not taken at a drop fraction."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

#: Fractions of the sweep.
SWEEP_DROPS = tuple(f"{tenth / 10:.1f}" for tenth in range(11))


def hidden_photos(
    listed: Mapping[str, Collection[str]] | None,
    drop: str,
    photos: Sequence[str],
    *,
    seed: int,
    house_id: str,
) -> list[str]:
    """Return the photos of a house that are hidden at drop fraction `drop` (``"0.3"``), sorted.

    What 0.2 hides, 0.4 hides too.

    Parameters
    ----------
    listed : mapping, optional
        The data set's ``unobserved_photos.json``: fraction to photos of all houses (sets, where
        many houses ask: a list is gone through each time). Between two of its fractions (Rent3D++
        goes in steps of 0.2), a share of what the larger one hides beyond the smaller is hidden,
        in a seeded order: none at 0.0, all photos at 1.0. Without a list that share of the
        house's photos, in a seeded order.
    photos : sequence of str
        All photos of the house.
    """
    known = {1.0: set(photos)}
    known |= {float(name): known[1.0].intersection(of) for name, of in (listed or {}).items()}
    known[0.0] = set()
    fraction = float(drop)
    low = max(value for value in known if value <= fraction)
    high = min(value for value in known if value >= fraction)
    if low == high:
        return sorted(known[low])
    from plan2scene.seeds import generator

    more = sorted(known[high] - known[low])
    count = round((fraction - low) / (high - low) * len(more))
    interval = () if listed is None else (f"{low:.1f}",)
    order = generator(seed, "hidden_photos", house_id, *interval).permutation(len(more))
    return sorted(known[low] | {more[i] for i in order[:count]})
