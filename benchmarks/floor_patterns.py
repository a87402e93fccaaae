"""Patterns of floors against sizes measured by hand.

``python benchmarks/floor_patterns.py TRUTH.csv FOLDER``

TRUTH.csv has home, room_id, kind (planks, tiles, plain), width_m, length_m and direction (x or z
of the plan); what is empty is not compared. FOLDER has ``{home}/patterns.parquet``; homes that it
has not are left out.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import pandas as pd

from plan2scene.io import read_parquet

AXES = {"x": 0.0, "z": 90.0}
#: Degrees within which a direction is right.
WITHIN_DEG = 10.0


def compared(truth: pd.Series, found: pd.Series | None) -> dict[str, object]:
    """Return a floor's kind, relative errors and whether its direction is right."""
    row: dict[str, object] = {"floor": f"{truth.home}/{truth.room_id}", "true": truth.kind}
    if found is None:
        return {**row, "found": "plain", "right": truth.kind == "plain"}
    row |= {"found": found.kind, "right": found.kind == truth.kind}
    for name in ("width_m", "length_m"):
        row[name] = round(found[name], 3)
        row[f"{name[:-2]} %"] = round(100 * (found[name] / truth[name] - 1), 1)
    axis = AXES.get(truth.direction)
    if axis is not None and np.isfinite(found.direction_deg):
        away = (found.direction_deg - axis + 90.0) % 180.0 - 90.0
        row["direction"] = abs(away) <= WITHIN_DEG
    return row


def main() -> None:
    """Print a row for each floor, then the medians."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("truth", type=Path)
    parser.add_argument("folder", type=Path)
    args = parser.parse_args()
    rows = []
    for home, floors in pd.read_csv(args.truth).groupby("home", sort=False):
        file = args.folder / str(home) / "patterns.parquet"
        if not file.is_file():
            print(f"{home}: no {file}")
            continue
        table = read_parquet(file)[0].set_index("room_id")
        for _, truth in floors.iterrows():
            found = table.loc[truth.room_id] if truth.room_id in table.index else None
            rows.append(compared(truth, found))
    result = pd.DataFrame(rows)
    print(result.to_string(index=False, na_rep=""))
    for name in ("width %", "length %"):
        errors = result[name].abs().dropna()
        print(f"{name}: median {errors.median():.1f}, worst {errors.max():.1f}, of {len(errors)}")
    print(f"kind right {result['right'].mean():.0%}, direction right", end=" ")
    print(f"{result['direction'].dropna().mean():.0%} of {result['direction'].notna().sum()}")


if __name__ == "__main__":
    main()
