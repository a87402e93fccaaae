"""Statistics of the benchmark's synthetic plans, for docs/measurements/benchmark.md.

python benchmarks/plans.py
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plan2scene.house import House
from plan2scene.plans.geometry import room_polygon
from plan2scene.seeds import derive_seed
from plan2scene_workshop.homes.floorplans import generate_house
from plan2scene_workshop.homes.residences import residence_names


def plan_values(houses: Sequence[House]) -> dict[str, list[float]]:
    """Return values over houses and rooms by name; doors count passages and the entrance."""
    values: dict[str, list[float]] = {}

    def note(name: str, value: float) -> None:
        values.setdefault(name, []).append(value)

    for house in houses:
        note("rooms per house", len(house.rooms))
        note("height (m)", house.rooms[0].height)
        areas = {room.id: room_polygon(room).area for room in house.rooms}
        note("floor area (m2)", sum(areas.values()))
        for room in house.rooms:
            openings = [o for wall in house.walls_of(room.id) for o in wall.openings]
            windows = sum(o.kind == "window" for o in openings)
            note("doors per room", len(openings) - windows)
            note("windows per room", windows)
            note("corners per room", len(room.rings[0]))
            note(f"area of {room.types[0]} (m2)", areas[room.id])
    return values


def main() -> None:
    """Print the table of the 215 plans."""
    names = residence_names("home", {"train": 129, "val": 43, "test": 43})
    houses = [generate_house(name, derive_seed(1, "house")) for name in names]
    print("| | n | mean | least | most |\n|---|---|---|---|---|")
    for name, values in sorted(plan_values(houses).items()):
        mean, least, most = np.mean(values), np.min(values), np.max(values)
        print(f"| {name} | {len(values)} | {mean:.2f} | {least:.2f} | {most:.2f} |")


if __name__ == "__main__":
    main()
