"""A surface quilted from patches without repeating (Efros and Freeman 2001).

Patches are chosen by what every pair of them costs side by side, then joined along minimum cuts,
found for a whole row of joints at once.
"""

from __future__ import annotations

import cv2
import numpy as np

from plan2scene.textures.maps.patches import Cell, Patches

_STRIP = 4  # pixels across a joint when patches are compared
_SWEEPS = 2  # times that every patch is chosen anew, with all four neighbours known
_WORN = 2.0  # what a place costs that is used as often as others in the mean, in fair joints
_BESIDE = 4.0  # what one costs that is there already nearer than `_NEAR`, in the same
_NEAR = 3  # patches
_FEATHER = 2.0  # px over which a cut blends


def quilted(patches: Patches, height: int, width: int, rng: np.random.Generator) -> np.ndarray:
    """Return a map (height, width, 3) uint8 of patches, none of it a repetition of the whole.

    Parameters
    ----------
    patches : Patches
    height, width : int
        Pixels.
    rng : numpy.random.Generator
        Draws the first patch, and breaks ties.
    """
    rows, columns = patches.down.count(height), patches.across.count(width)
    chosen = choose(patches, rows, columns, rng)
    pieces = np.stack([[patches.pixels(int(number)) for number in row] for row in chosen])
    strips = _chained(pieces.swapaxes(2, 3), patches.across, width).swapaxes(1, 2)
    return np.ascontiguousarray(_chained(strips[None], patches.down, height)[0])


def choose(patches: Patches, rows: int, columns: int, rng: np.random.Generator) -> np.ndarray:
    """Return the numbers of the patches of a grid, (rows, columns) int."""
    beside, below = _costs(patches)
    count = len(beside)
    usual = max(float(_fair(beside) + _fair(below)) / 2, 1e-6)
    beside, below = beside / usual, below / usual
    near, worn = _alike(patches), np.zeros(count, np.float32)
    grid = np.full((rows, columns), -1)
    tie = 0.05 * rng.random((rows, columns, count)).astype(np.float32)

    def best(i: int, j: int) -> int:
        cost = tie[i, j] + _WORN * worn
        if j and grid[i, j - 1] >= 0:
            cost = cost + beside[grid[i, j - 1]]
        if i and grid[i - 1, j] >= 0:
            cost = cost + below[grid[i - 1, j]]
        if j + 1 < columns and grid[i, j + 1] >= 0:
            cost = cost + beside[:, grid[i, j + 1]]
        if i + 1 < rows and grid[i + 1, j] >= 0:
            cost = cost + below[:, grid[i + 1, j]]
        around = grid[max(0, i - _NEAR) : i + _NEAR + 1, max(0, j - _NEAR) : j + _NEAR + 1]
        taken = near[around[around >= 0]].max(axis=0, initial=0.0)
        return int((cost + _BESIDE * taken).argmin())

    usual_wear = near.mean() * rows * columns
    near_worn = near / max(usual_wear, 1.0)
    for _ in range(1 + _SWEEPS):
        for i, j in np.ndindex(rows, columns):
            if grid[i, j] >= 0:
                worn -= near_worn[grid[i, j]]
                grid[i, j] = -1
            grid[i, j] = best(i, j)
            worn += near_worn[grid[i, j]]
    return grid


def _alike(patches: Patches) -> np.ndarray:
    """Return how much two patches show the same place, (n, n) float32: 1 the same, 0 apart."""
    apart = np.abs(patches.shown[:, None] - patches.shown[None])
    sides = np.array([patches.across.side, patches.down.side])
    shared = np.clip(1 - apart[..., 1:] / sides, 0, 1).prod(axis=2)
    return np.where(apart[..., 0] == 0, shared, 0.0).astype(np.float32)


def _fair(costs: np.ndarray) -> float:
    """Return what a patch costs beside its tenth best neighbour, in the median."""
    few = min(10, len(costs) - 1)
    return float(np.median(np.partition(costs, few, axis=1)[:, few]))


def _places(patches: Patches) -> np.ndarray:
    """Return a number for each patch, (n,), which those that show the same place share."""
    half = np.array([1, patches.down.side // 2 + 1, patches.across.side // 2 + 1])
    return np.unique(patches.places // half, axis=0, return_inverse=True)[1].ravel()


def _costs(patches: Patches) -> tuple[np.ndarray, np.ndarray]:
    """Return what a patch (first index) costs left of another, and above it, (n, n) float32."""
    down, across = patches.down, patches.across
    scale = _STRIP / min(down.overlap, across.overlap)
    shape = (
        max(2 * _STRIP, round(across.side * scale)),
        max(2 * _STRIP, round(down.side * scale)),
    )
    numbers = range(len(patches.places))
    small = np.stack(
        [cv2.resize(patches.pixels(n), shape, interpolation=cv2.INTER_AREA) for n in numbers]
    ).astype(np.float32)
    # What lies one step on in a patch lies at the beginning of the next.
    x = min(round(across.step * shape[0] / across.side), shape[0] - _STRIP)
    y = min(round(down.step * shape[1] / down.side), shape[1] - _STRIP)
    return (
        _apart(small[:, :, x : x + _STRIP], small[:, :, :_STRIP]),
        _apart(small[:, y : y + _STRIP], small[:, :_STRIP]),
    )


def _apart(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the mean squared differences of two sets of strips, (n, n) float32."""
    a, b = (strips.reshape(len(strips), -1) for strips in (first, second))
    squares = (a**2).sum(axis=1)[:, None] + (b**2).sum(axis=1)[None, :] - 2.0 * a @ b.T
    return np.asarray(np.maximum(squares, 0.0) / a.shape[1])


def _chained(pieces: np.ndarray, axis: Cell, length: int) -> np.ndarray:
    """Return chains (b, n, side, w, 3) of pieces joined one below the other, (b, length, w, 3)."""
    starts, joint = axis.starts(pieces.shape[1]), axis.overlap
    shape = (len(pieces), int(starts[-1]) + axis.side, *pieces.shape[3:])
    canvas = np.zeros(shape, np.uint8)
    canvas[:, : axis.side] = pieces[:, 0]
    if pieces.shape[1] > 1:
        upper = [pieces[:, k, s : s + joint] for k, s in enumerate(np.diff(starts))]
        joined = _joined(np.stack(upper, axis=1), pieces[:, 1:, :joint])
        for k, start in enumerate(starts[1:]):
            canvas[:, start : start + joint] = joined[:, k]
            canvas[:, start + joint : start + axis.side] = pieces[:, k + 1, joint:]
    return canvas[:, :length]


def _joined(upper: np.ndarray, lower: np.ndarray) -> np.ndarray:
    """Return overlaps (..., h, w, 3) uint8: above a cut along w one, below it the other."""
    shape = upper.shape
    upper, lower = (part.reshape(-1, *shape[-3:]) for part in (upper, lower))
    difference = upper.astype(np.float32) - lower
    cut = _cuts(np.einsum("nhwc,nhwc->wnh", difference, difference))
    down = np.arange(shape[-3], dtype=np.float32)[None, :, None]
    share = np.clip((down - cut.T[:, None, :]) / _FEATHER + 0.5, 0.0, 1.0)[..., None]
    return np.rint(upper - share * difference).astype(np.uint8).reshape(shape)


def _cuts(error: np.ndarray) -> np.ndarray:
    """Return the place across of the cheapest path along errors (length, n, width), int.

    (length, n): all n paths are found at once.
    """
    length, count, width = error.shape
    total = np.full((length, count, width + 2), np.inf, np.float32)
    total[:, :, 1:-1] = error
    least = np.empty((count, width), np.float32)
    for k in range(1, length):
        before = total[k - 1]
        np.minimum(before[:, :-2], before[:, 2:], out=least)
        np.minimum(least, before[:, 1:-1], out=least)
        total[k, :, 1:-1] += least
    path = np.empty((length, count), int)
    path[-1] = total[-1].argmin(axis=1)
    index = np.arange(count)
    for k in range(length - 2, -1, -1):
        at = path[k + 1]
        near = np.stack([total[k, index, at - 1], total[k, index, at], total[k, index, at + 1]])
        path[k] = at + near.argmin(axis=0) - 1
    return path - 1
