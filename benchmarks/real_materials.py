"""Measure which surfaces of real flats are rightly joined as one material.

``python benchmarks/real_materials.py RESULTS FLAT... [--substances CSV]``

RESULTS is a data set's folder of results, FLAT a folder named as its house. The CSV
(``benchmarks/substances.csv``) has the substance of each surface as judged by eye. In its flats,
all surfaces of one kind and substance are one material; for example, all walls of a flat have one
white paint, but light makes them differ by 2 to 30 dE2000. A pair is two surfaces of one kind in
two rooms, both with crops. It is joined if ``materials.parquet`` gives both the same material.
"""

from __future__ import annotations

import argparse
from collections import Counter
from itertools import combinations
from pathlib import Path

from real_house import markdown
from substances import read_seen

from plan2scene.house import SURFACES
from plan2scene.io import read_parquet

Surface = tuple[str, str]  # room, surface


def pairs(results: Path, house: str, seen: dict[Surface, str]) -> Counter[tuple[str, bool, bool]]:
    """Return the number of pairs by kind, by whether they are truly one material, and joined."""
    table, _ = read_parquet(results / "drop_0.0" / house / "materials.parquet")
    joined = {(row.room_id, row.surface): row.material for row in table.itertuples()}
    crops, _ = read_parquet(results / "houses" / house / "crops.parquet")
    shown = set(zip(crops["room_id"], crops["surface"], strict=True))
    found: Counter[tuple[str, bool, bool]] = Counter()
    for kind in SURFACES:
        surfaces = sorted(key for key in shown & set(seen) if key[1] == kind)
        for a, b in combinations(surfaces, 2):
            together = a in joined and joined[a] == joined.get(b)
            found[kind, seen[a] == seen[b], together] += 1
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path)
    parser.add_argument("flats", type=Path, nargs="+")
    parser.add_argument(
        "--substances", type=Path, default=Path(__file__).with_name("substances.csv")
    )
    given = parser.parse_args()
    seen = read_seen(given.substances)
    rows = []
    for flat in given.flats:
        of_flat = {
            (room, kind): what for (name, room, kind), what in seen.items() if name == flat.name
        }
        count = pairs(given.results, flat.name, of_flat)
        for kind in SURFACES:
            row: dict[str, object] = {"house": flat.name, "kind": kind}
            for one, name in ((True, "one"), (False, "two")):
                row[f"pairs of {name}"] = count[kind, one, True] + count[kind, one, False]
                row["joined" if one else "joined wrongly"] = count[kind, one, True]
            rows.append(row)
    print(markdown(rows))


if __name__ == "__main__":
    main()
