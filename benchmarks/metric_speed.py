"""Milliseconds per pair of COLOR, FREQ and TILE, beside those of the paper's own code.

    OMP_NUM_THREADS=1 python benchmarks/metric_speed.py

One thread and its processor time, so that waiting for other jobs does not count. A house's pairs
are measured as one batch, as the workflow does: synthetic materials against other ones. TILE looks
at the prediction only. Printed are the median and the least of the rounds (a busy neighbour on the
same core lengthens a round, nothing shortens it), and what the first call of a process costs more,
since it makes tables.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import cv2
import numpy as np

from plan2scene.house import SUBSTANCES
from plan2scene.materials import random_material
from plan2scene.metrics.color_freq_tile import color_distance, freq_distance, tile_score

#: Milliseconds per pair of the paper's code on one core, and how many times faster we must be.
OFFICIAL = {"COLOR": (41.9, 50), "FREQ": (1.2, 2), "TILE": (0.2, 2)}


def materials(count: int, seed: int) -> np.ndarray:
    """Return (count, 128, 128, 3) uint8 tiles, the substances in turn."""
    return np.stack(
        [
            random_material(SUBSTANCES[i % len(SUBSTANCES)], seed + i, size_px=128).albedo
            for i in range(count)
        ]
    )


def milliseconds(measure: Callable[[], object], rounds: int) -> tuple[float, float, float]:
    """Return the first, the median and the least processor time of a call."""
    times = []
    for _ in range(rounds + 1):
        start = time.thread_time()
        measure()
        times.append(1000 * (time.thread_time() - start))
    return times[0], float(np.median(times[1:])), min(times[1:])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--pairs", type=int, default=24, help="surfaces of a house")
    parser.add_argument("--rounds", type=int, default=50)
    given = parser.parse_args()
    cv2.setNumThreads(1)
    a, b = materials(given.pairs, 1000), materials(given.pairs, 2000)
    calls = {
        "COLOR": lambda: color_distance(a, b),
        "FREQ": lambda: freq_distance(a, b),
        "TILE": lambda: tile_score(a),
    }
    print(f"{given.pairs} pairs in a batch, {given.rounds} rounds, ms per pair")
    print("| metric | median | least | official | faster (median) | asked | first call, ms more |")
    print("|---|---|---|---|---|---|---|")
    for name, call in calls.items():
        first, median, least = milliseconds(call, given.rounds)
        official, asked = OFFICIAL[name]
        faster = official / (median / given.pairs)
        print(
            f"| {name} | {median / given.pairs:.3f} | {least / given.pairs:.3f} | {official} "
            f"| {faster:.3g}x | {asked}x | {first - median:.1f} |"
        )


if __name__ == "__main__":
    main()
