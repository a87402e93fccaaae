"""Compare patterns of floors with sizes measured by hand, and measure how much they repeat.

``python benchmarks/floor_patterns.py benchmarks/floors.csv FOLDER``

Or ``... data/benchmark/truth/test results/benchmark/houses``, for the kinds of floors of synthetic
homes.

The table has home, room_id, kind (planks, tiles, plain ...), width_m, length_m and direction (x or
z of the plan); empty cells are not compared. FOLDER has ``{home}/patterns.parquet``; homes without
it are left out. A confidence is the probability that the kind is right: printed are its means over
right and wrong kinds, and the Brier score. Repetition (``repetition.py``) is that of 4 x 4 m of
each pattern: as laid, of its joints alone (1 for any regular bond), without joints, and without
joints at lags beyond one board (the grain of a board is like itself).
"""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pandas as pd
from repetition import repetition

from plan2scene.io import read_parquet
from plan2scene.plans.surface_areas import Area
from plan2scene.textures.laying import LaidPattern, laid, read_patterns

#: Kind of pattern of the workshop's materials.
KINDS = {
    **dict.fromkeys(("planks", "strip"), "planks"),
    **dict.fromkeys(("basket", "brick", "checker", "diagonal", "grid", "hexagon"), "tiles"),
    **dict.fromkeys(("cut", "loop", "fleck", "plain", "patterned", "terrazzo"), "plain"),
    **{kind: kind for kind in ("herringbone", "chevron", "mosaic")},
    "marble": "tiles",
}
AXES = {"x": 0.0, "z": 90.0}
#: Largest error of a right direction in degrees.
WITHIN_DEG = 10.0
#: Side in metres of the floors whose repetition is measured, and their pixels per metre.
SIDE_M, SHOWN_PX_PER_M = 4.0, 64.0


def compared(truth: pd.Series, found: pd.Series | None) -> dict[str, object]:
    """Return the comparison of a floor: kinds, relative errors in %, rightness of direction."""
    row: dict[str, object] = {"floor": f"{truth.home}/{truth.room_id}", "true": truth.kind}
    if found is None:
        return {**row, "found": "plain", "right": truth.kind == "plain"}
    row |= {"found": found.kind, "right": found.kind == truth.kind, "sure": found.confidence}
    for name in ("width_m", "length_m"):
        row[name] = round(found[name], 3)
        row[f"{name[:-2]} %"] = round(100 * (found[name] / truth[name] - 1), 1)
    axis = AXES.get(truth.direction, float("nan"))
    away = abs((found.direction_deg - axis + 90.0) % 180.0 - 90.0)
    row["direction"] = away <= WITHIN_DEG if np.isfinite(away) else None
    return row


def of_synthetic(folder: Path) -> pd.DataFrame:
    """Return the table of floors of synthetic homes, from ``{home}/materials.json``.

    Sizes are not compared, because a material's size is that of a tile with several units.
    """
    rows = [
        {"home": file.parent.name, "room_id": name.partition("/")[0], "kind": KINDS[made["kind"]]}
        for file in sorted(folder.glob("*/materials.json"))
        for name, made in json.loads(file.read_text(encoding="utf-8")).items()
        if name.endswith("/floor") and made["kind"] in KINDS
    ]
    empty = {"width_m": np.nan, "length_m": np.nan, "direction": ""}
    return pd.DataFrame(rows).assign(**empty)


def repeats(pattern: LaidPattern) -> list[float]:
    """Return the repetition of a laid floor: as laid, joints alone, no joints, beyond a board."""
    pattern = replace(pattern, direction_deg=0.0)
    flat = [np.full_like(unit, 127) for unit in pattern.units]
    variants = pattern, replace(pattern, units=flat), replace(pattern, joint=np.zeros(3))
    found = []
    for variant in variants:
        image, _ = laid(variant, Area((0.0, 0.0), (SIDE_M, SIDE_M)), np.full(3, 0.5), 0)
        side = round(SIDE_M * SHOWN_PX_PER_M)
        small = cv2.resize(image, (side, side), interpolation=cv2.INTER_AREA)
        found.append(round(repetition(small, SHOWN_PX_PER_M), 2))
    run = (pattern.longest_m, pattern.width_m / 2)
    return [*found, round(repetition(small, SHOWN_PX_PER_M, run), 2)]


def main() -> None:
    """Print a row for each floor, then the medians."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("truth", type=Path)
    parser.add_argument("folder", type=Path)
    args = parser.parse_args()
    rows, repeated = [], {}
    synthetic = args.truth.is_dir()
    truths = of_synthetic(args.truth) if synthetic else pd.read_csv(args.truth)
    for home, floors in truths.groupby("home", sort=False):
        file = args.folder / str(home) / "patterns.parquet"
        if not file.is_file():
            print(f"{home}: no {file}")
            continue
        table = read_parquet(file)[0]
        table = table[table["surface"] == "floor"].set_index("room_id")
        for _, truth in floors.iterrows():
            found = table.loc[truth.room_id] if truth.room_id in table.index else None
            if found is not None or not synthetic:  # synthetic homes have rooms without photos
                rows.append(compared(truth, found))
        for pattern in read_patterns(file).values():
            name = f"{home}: {pattern.words}, {len(pattern.units)} units"
            if pattern.units and name not in repeated:
                repeated[name] = repeats(pattern)
    result = pd.DataFrame(rows)
    print(result.to_string(index=False, na_rep=""))
    for name in ("width %", "length %"):
        errors = result[name].abs().dropna()
        print(f"{name}: median {errors.median():.1f}, worst {errors.max():.1f}, of {len(errors)}")
    print(f"kind right {result['right'].mean():.0%}, direction right", end=" ")
    print(f"{result['direction'].dropna().mean():.0%} of {result['direction'].notna().sum()}")
    known = result.dropna(subset=["sure"])
    right = known["right"].astype(float)
    means = known.groupby("right")["sure"].mean().round(2).to_dict()
    print(f"confidence {means}, Brier {((known['sure'] - right) ** 2).mean():.3f} of {len(known)}")
    print("repetition as laid, of joints alone, between joints, beyond a board")
    for name, values in repeated.items():
        print(f"{name}: {values}")


if __name__ == "__main__":
    main()
