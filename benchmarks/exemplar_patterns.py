"""Regular patterns with known periods, for benchmarks/exemplar.py."""

from __future__ import annotations

import numpy as np

from plan2scene.materials import bonds
from plan2scene.seeds import derive_seed
from plan2scene.textures.exemplar.make import Exemplar, ExemplarCrop, make_exemplar
from plan2scene_workshop.texture.degradation import Degradation, degrade

KINDS = ("grid", "brick", "planks")
SIZE = 128
_NEAR = 0.03


def draw(kind: str, rng: np.random.Generator) -> tuple[np.ndarray, list[tuple[float, float]]]:
    """Return a tile (128, 128, 3) uint8 and the periods (x, y) in tile sides that are right.

    NaN: any period is right. A brick bond repeats after two rows, but its joints repeat after one
    row, so both periods are right.
    """
    if kind == "grid":
        columns, rows = rng.integers(3, 8, 2)
        offsets = np.zeros(rows)
        periods = [(1 / columns, 1 / rows)]
    elif kind == "brick":
        columns, rows = int(rng.integers(2, 5)), 2 * int(rng.integers(3, 7))
        offsets = np.arange(rows) * 0.5
        periods = [(1 / columns, 2 / rows), (1 / columns, 1 / rows)]
    else:
        columns, rows = int(rng.integers(1, 3)), int(rng.integers(4, 11))
        offsets = rng.uniform(0.0, 1.0, rows)
        periods = [(float("nan"), 1 / rows)]
    plan = bonds.bond(SIZE, int(columns), int(rows), 1.0, offsets)
    tone = rng.uniform(60.0, 200.0, 3)
    joint = tone + rng.choice([-1.0, 1.0]) * rng.uniform(35.0, 55.0)
    share = plan.joint(float(rng.uniform(0.012, 0.03)))[..., None]
    units = tone + plan.draw(rng, float(rng.uniform(2.0, 12.0)))[..., None]
    units = units + rng.normal(0.0, 4.0, (SIZE, SIZE, 1))
    return np.clip(np.rint(units * (1 - share) + joint * share), 0, 255).astype(np.uint8), periods


def autocorrelation(tile: np.ndarray, periods: tuple[float, float]) -> float:
    """Return the smaller autocorrelation of the repeated tile at one period along x and along y.

    `periods` are in pixels; a direction with NaN is left out. The better of the two integer lags
    next to a period counts.
    """
    grey = tile.astype(np.float64).mean(axis=2)
    grey -= grey.mean()
    spectrum = np.abs(np.fft.fft2(grey)) ** 2
    correlation = np.fft.ifft2(spectrum).real / max(spectrum.mean(), 1e-9)
    found = []
    for axis, period in enumerate(periods):
        if np.isfinite(period):
            lags = [int(np.floor(period)), int(np.floor(period)) + 1]
            line = correlation[0] if axis == 0 else correlation[:, 0]
            found.append(max(float(line[lag % SIZE]) for lag in lags))
    return min(found)


def _judge(
    made: Exemplar | None, tile: np.ndarray, truth: list[tuple[float, float]]
) -> tuple[bool, float]:
    """Return whether the periods were found, and the autocorrelation over that of the truth."""
    if made is None:
        return False, 0.0
    cut, nan = made.pattern.cut, float("nan")
    counts = cut.columns, cut.rows
    sides = zip((cut.wide, cut.high), counts, strict=True)
    period_m = [made.pattern.size_m * side / count if count else nan for side, count in sides]
    for periods in truth:
        for swap in (False, True):  # a turn by more than 45 degrees exchanges the axes
            wanted = periods[::-1] if swap else periods
            errors = [
                abs(found / want - 1.0) if np.isfinite(found) else 1.0
                for found, want in zip(period_m, wanted, strict=True)
                if np.isfinite(want)
            ]
            if max(errors) <= _NEAR:
                px = tuple(
                    SIZE / count if np.isfinite(want) else nan
                    for count, want in zip(counts, wanted, strict=True)
                )
                ours = autocorrelation(made.image, (px[0], px[1]))
                theirs = autocorrelation(tile, (periods[0] * SIZE, periods[1] * SIZE))
                return True, ours / theirs
    return False, 0.0


def pattern_rows(cases: int, turn_deg: float) -> list[tuple[str, list[str]]]:
    """Return a table row for each kind: cases, share of right periods, autocorrelation."""
    rows = []
    for kind in KINDS:
        judged = []
        for case in range(cases):
            seed = derive_seed(0, "pattern", kind, case)
            tile, truth = draw(kind, np.random.default_rng(seed))
            turn = float(np.random.default_rng(seed + 1).uniform(-turn_deg, turn_deg))
            crops = degrade(tile, seed, how=Degradation(turn_deg=turn))
            given = [ExemplarCrop(crop.image, crop.side, crop.side) for crop in crops]
            judged.append(_judge(make_exemplar(given, size_px=SIZE), tile, truth))
        right = np.array([found for found, _ in judged])
        shares = np.array([share for found, share in judged if found])
        median = f"{np.median(shares):.2f}" if len(shares) else "-"
        rows.append(
            (
                f"{kind}, {turn_deg:g} deg",
                [str(cases), f"{right.mean():.2f}", median, f"{(shares >= 0.9).sum() / cases:.2f}"],
            )
        )
    return rows
