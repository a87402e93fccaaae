"""Quilting: patches of a surface's crops joined along cuts, as a tile that repeats or as a map.

A tile is quilted on a torus: the best crop is laid down, then patches of all crops, at the offsets
where they fit best, cover what is left. The tile is rebuilt from the gradients of its patches: this
removes the last brightness steps from the joints. A map is quilted on a grid: patches are chosen by
the cost of each pair side by side.

All joints are minimum cuts (Kwatra et al. 2003, DOI 10.1145/882262.882264). Between regions of any
shape a cut is a maximum flow (:func:`minimum_cut`, scipy's). Across a strip it is a cheapest path
(:func:`cheapest_paths`; Efros and Freeman 2001, DOI 10.1145/383259.383296): a map has hundreds of
strips of equal size. Dynamic programming cuts them all at once in numpy. A maximum flow, or a call
of ``skimage.graph`` for each strip, would take longer than all other work on the map.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import breadth_first_order, maximum_flow


@dataclass(frozen=True)
class QuiltSettings:
    """How patches are laid and chosen. Chosen by looking at tiles and maps of development crops."""

    first: float = 0.82  #: largest side of the first patch over the torus's
    expected: float = 0.5  #: weight of a pixel predicted from the periods, over a laid pixel's
    rim: int = 2  #: width, px, of a patch's border that never replaces pixels already laid
    #: cost of a joint where only one side has pixels, as a sum of absolute sRGB differences
    empty_cost: float = 0.05
    overlap: float = 0.15  #: least share of a patch's area that lies on pixels already laid
    gain: float = 0.02  #: least area that a patch fills, over its own or the empty (smaller) area
    strip: int = 4  #: width of an overlap, px, in the shrunk patches of a map that are compared
    sweeps: int = 2  #: times that every patch of a map is chosen anew, with all neighbours known
    #: worn, beside: Costs of a place in the photos, as multiples of the cost of a fair joint
    #: (:func:`_fair`): if the map uses it as often as places are used on average, and if a patch
    #: at most `near` patches away shows it already.
    worn: float = 2.0
    beside: float = 4.0
    near: int = 3
    feather: float = 2.0  #: width, px, over which a map's joint is blended


_S = QuiltSettings()
_UNITS = 1000.0  # capacities of a flow are whole numbers
_BIG = 10_000_000
_VALUES = 4_000_000  # costs held at once where paths close: 32 MB


def minimum_cut(
    cost: tuple[np.ndarray, np.ndarray], old: np.ndarray, new: np.ndarray
) -> np.ndarray:
    """Return (h, w) bool: the pixels that the patch takes.

    `cost` are two (h, w) arrays: the costs of a joint between each pixel and its lower neighbour,
    and its right neighbour, wrapped around. `old` (h, w) bool are pixels that have to stay, `new`
    (h, w) bool are pixels that the patch has to take.
    """
    height, width = old.shape
    free = ~(old | new)
    nodes = np.full((height, width), -1)
    nodes[free] = np.arange(int(free.sum()))
    count = int(free.sum())
    source, sink = count, count + 1
    nodes[old], nodes[new] = source, sink
    heads, tails, weights = [], [], []
    for axis in (0, 1):
        other = np.roll(nodes, -1, axis=axis)
        used = nodes != other
        heads.append(nodes[used])
        tails.append(other[used])
        weights.append(cost[axis][used])
    head, tail = np.concatenate(heads), np.concatenate(tails)
    capacity = np.minimum(np.rint(np.concatenate(weights) * _UNITS) + 1, _BIG).astype(np.int32)
    graph = coo_matrix(
        (np.r_[capacity, capacity], (np.r_[head, tail], np.r_[tail, head])),
        shape=(count + 2, count + 2),
    ).tocsr()
    graph.data = np.minimum(graph.data, _BIG).astype(np.int32)
    residual = graph - maximum_flow(graph, source, sink).flow
    residual.eliminate_zeros()
    reached = np.zeros(count + 2, dtype=bool)
    reached[breadth_first_order(residual, source, return_predecessors=False)] = True
    return ~reached[nodes]


def cheapest_paths(error: np.ndarray, *, closed: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Return the cheapest path along each of n strips, (length, n) int across, and its cost (n,).

    `error` (length, n, width) is the cost of passing a pixel. A path moves at most one pixel across
    per step along; a `closed` one has to end where it began (within one pixel).
    """
    if closed:
        return _closed_paths(error)
    total = _path_costs(error)
    return _traced(total, total[-1].argmin(axis=1)), total[-1].min(axis=1)


def _closed_paths(error: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return each strip's cheapest path that closes on itself (the best over all starts)."""
    length, count, width = error.shape
    column = np.arange(width)
    paths, costs = [], []
    at_once = max(1, _VALUES // (length * width**2))
    for strips in np.split(error, range(at_once, count, at_once), axis=1):
        # Every strip once for each start (length, n * starts, width).
        from_each = np.repeat(strips, width, axis=1)
        starts = np.tile(column, strips.shape[1])
        from_each[0, starts[:, None] != column] = np.inf
        total = _path_costs(from_each)
        # A path that ends more than a pixel off its start would leave a step.
        ends = np.where(np.abs(starts[:, None] - column) > 1, np.inf, total[-1])
        ends = ends.reshape(strips.shape[1], -1)
        start, end = np.divmod(ends.argmin(axis=1), width)
        paths.append(_traced(total[:, np.arange(len(start)) * width + start], end))
        costs.append(ends.min(axis=1))
    return np.concatenate(paths, axis=1), np.concatenate(costs)


def _path_costs(error: np.ndarray) -> np.ndarray:
    """Return the cost (length, n, width) of the cheapest path to each pixel of strips."""
    length, count, width = error.shape
    total = np.full((length, count, width + 2), np.inf, error.dtype)
    total[:, :, 1:-1] = error
    least = np.empty((count, width), error.dtype)
    for k in range(1, length):
        before = total[k - 1]
        np.minimum(before[:, :-2], before[:, 2:], out=least)
        np.minimum(least, before[:, 1:-1], out=least)
        total[k, :, 1:-1] += least
    return total[:, :, 1:-1]


def _traced(total: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return the paths (length, n) int that lead to `end` (n,), by costs (length, n, width)."""
    length, count, width = total.shape
    path = np.empty((length, count), int)
    path[-1] = end
    index = np.arange(count)[:, None]
    for k in range(length - 2, -1, -1):
        around = path[k + 1][:, None] + np.array([-1, 0, 1])
        near = total[k, index, np.clip(around, 0, width - 1)]
        near[(around < 0) | (around >= width)] = np.inf
        path[k] = path[k + 1] + near.argmin(axis=1) - 1
    return path


@dataclass(frozen=True, eq=False)
class Source:
    """A straightened crop at the tile's scale: (h, w, 3) float32 and its valid pixels (h, w)."""

    image: np.ndarray
    valid: np.ndarray


class Canvas:
    """A torus of `size` px that patches are laid on."""

    def __init__(self, size: int) -> None:
        self.size = size
        self.image = np.zeros((size, size, 3), np.float32)
        self.filled = np.zeros((size, size), bool)
        #: down, right: Gradients from each pixel to its lower, and to its right neighbour
        self.down, self.right = np.zeros_like(self.image), np.zeros_like(self.image)

    def lay(self, source: Source, offset: tuple[int, int]) -> None:
        """Lay a patch, its corner at `offset`.

        It fills empty pixels; elsewhere a minimum cut decides what it takes.
        """
        patch, valid = np.zeros_like(self.image), np.zeros_like(self.filled)
        height, width = source.valid.shape
        patch[:height, :width], valid[:height, :width] = source.image, source.valid
        patch, valid = np.roll(patch, offset, (0, 1)), np.roll(valid, offset, (0, 1))
        inner = cv2.erode(
            np.pad(valid, _S.rim, mode="wrap").astype(np.uint8),
            np.ones((2 * _S.rim + 1,) * 2, np.uint8),
        )[_S.rim : -_S.rim, _S.rim : -_S.rim].astype(bool)
        new = valid & ~self.filled
        old = (self.filled & ~inner & ~new) | ~valid
        if not old.any():
            taken = valid
        else:
            difference = np.abs(self.image - patch).sum(axis=2)
            difference[~(self.filled & valid)] = _S.empty_cost
            down, right = (difference + np.roll(difference, -1, axis) for axis in (0, 1))
            taken = minimum_cut((down, right), old, new)
        self._merge(patch, valid, taken)

    def _merge(self, patch: np.ndarray, valid: np.ndarray, taken: np.ndarray) -> None:
        """Take pixels and gradients of a patch; joints get the mean of both sides' gradients."""
        for axis, gradients in ((0, self.down), (1, self.right)):
            beside = np.roll(taken, -1, axis)
            patch_step = np.roll(patch, -1, axis) - patch
            known = self.filled & np.roll(self.filled, -1, axis)
            possible = valid & np.roll(valid, -1, axis)
            inside = taken & beside
            gradients[inside] = patch_step[inside]
            joint = taken != beside
            both = joint & known & possible
            gradients[both] = (gradients[both] + patch_step[both]) / 2
            single = joint & ~known & possible
            gradients[single] = patch_step[single]
        self.image[taken] = patch[taken]
        self.filled |= taken

    def solve(self) -> np.ndarray:
        """Return the image (s, s, 3) with the patches' gradients and mean (Poisson equation)."""
        divergence = sum(g - np.roll(g, 1, axis) for g, axis in ((self.down, 0), (self.right, 1)))
        wave = 2.0 * np.cos(2.0 * np.pi * np.arange(self.size) / self.size)
        laplace = wave[:, None] + wave[None, :] - 4.0
        laplace[0, 0] = 1.0
        spectrum = np.fft.fft2(divergence, axes=(0, 1)) / laplace[..., None]
        spectrum[0, 0] = self.image.sum(axis=(0, 1))
        return np.fft.ifft2(spectrum, axes=(0, 1)).real


def quilt(sources: Sequence[Source], size: int, periods: tuple[int, int] = (0, 0)) -> Canvas:
    """Return a filled torus of `size` px; `sources` the best first, none larger than it.

    `periods` is how often the pattern repeats along x and y; 0 without a period. A patch also has
    to fit the pixels that were laid whole periods away, so that joints keep their distance.
    ValueError if no source has valid pixels.
    """
    if not any(source.valid.any() for source in sources):
        raise ValueError("no source has valid pixels")
    canvas = Canvas(size)
    canvas.lay(_middle(sources[0], round(_S.first * size)), (0, 0))
    spectra = [_spectra(source, size) for source in sources]
    while not canvas.filled.all():
        index, offset = _best_offset(canvas, spectra, periods) or _anywhere(canvas, sources)
        canvas.lay(sources[index], offset)
    return canvas


def _middle(source: Source, side: int) -> Source:
    """Return a source whose valid pixels lie within the middle square of `side` px."""
    valid = np.zeros_like(source.valid)
    top, left = (max(0, (n - side) // 2) for n in valid.shape)
    part = slice(top, top + side), slice(left, left + side)
    valid[part] = source.valid[part]
    return Source(source.image, valid)


def _anywhere(canvas: Canvas, sources: Sequence[Source]) -> tuple[int, tuple[int, int]]:
    """Return a source and an offset that fill the first empty pixel, for when no patch fits."""
    index = next(k for k, source in enumerate(sources) if source.valid.any())
    places = np.argwhere(~canvas.filled)[0]
    valid = np.argwhere(sources[index].valid)
    inside = valid[len(valid) // 2]
    row, column = (places - inside) % canvas.size
    return index, (int(row), int(column))


def _spectra(source: Source, size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return conjugate spectra of a source's validity, values and squared values."""
    valid = np.zeros((size, size))
    image = np.zeros((size, size, 3))
    height, width = source.valid.shape
    valid[:height, :width] = source.valid
    image[:height, :width] = source.image * source.valid[..., None]
    return (
        np.fft.rfft2(valid).conj(),
        np.fft.rfft2(image, axes=(0, 1)).conj(),
        np.fft.rfft2((image**2).sum(axis=2)).conj(),
    )


def _best_offset(
    canvas: Canvas, spectra: Sequence[tuple[np.ndarray, ...]], periods: tuple[int, int]
) -> tuple[int, tuple[int, int]] | None:
    """Return the source and offset with the least misfit for the area filled; None if none fits."""
    known, weight = _expected(canvas, periods)
    shape = canvas.filled.shape
    f_filled = np.fft.rfft2(canvas.filled.astype(np.float64))
    f_weight = np.fft.rfft2(weight)
    f_known = np.fft.rfft2(known * weight[..., None], axes=(0, 1))
    f_square = np.fft.rfft2((known**2).sum(axis=2) * weight)
    best = (np.inf, 0, (0, 0))
    empty = float((~canvas.filled).sum())
    for index, (valid, image, square) in enumerate(spectra):
        overlap = np.fft.irfft2(f_filled * valid, s=shape)
        weighed = np.fft.irfft2(f_weight * valid, s=shape)
        error = np.fft.irfft2(
            f_square * valid - 2.0 * (f_known * image).sum(axis=2) + f_weight * square, s=shape
        )
        area = float(valid[0, 0].real)
        gain = (area - overlap) / min(area, empty)
        misfit = np.sqrt(np.maximum(error, 0.0) / np.maximum(weighed, 1.0))
        score = np.where(
            (overlap > _S.overlap * area) & (gain > _S.gain),
            misfit / np.clip(gain, _S.gain, 1.0) ** 0.5,
            np.inf,
        )
        at = int(score.argmin())
        if score.flat[at] < best[0]:
            best = (float(score.flat[at]), index, (at // shape[1], at % shape[1]))
    return (best[1], best[2]) if np.isfinite(best[0]) else None


def _expected(canvas: Canvas, periods: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return the laid pixels, or predictions from whole periods away, (s, s, 3); weights (s, s)."""
    filled = canvas.filled.astype(np.float64)
    columns, rows = (max(1, count) for count in periods)
    total, times = np.zeros(canvas.image.shape), np.zeros_like(filled)
    for row in range(rows):
        for column in range(columns):
            by = round(row * canvas.size / rows), round(column * canvas.size / columns)
            share = np.roll(filled, by, (0, 1))
            total += np.roll(canvas.image, by, (0, 1)) * share[..., None]
            times += share
    known = np.where(
        canvas.filled[..., None], canvas.image, total / np.maximum(times, 1)[..., None]
    )
    return known, np.where(canvas.filled, 1.0, _S.expected * (times > 0))


@dataclass(frozen=True)
class Cell:
    """How patches lie along one axis, in pixels: one every `step`, with joints `overlap` wide.

    `step` need not be whole. `period` is the lattice's, NaN where there is none.
    """

    step: float
    overlap: int
    period: float

    @property
    def side(self) -> int:
        """Return a patch's side."""
        return math.ceil(self.step) + self.overlap + 1

    def count(self, length: int) -> int:
        """Return how many patches cover a length."""
        return max(1, math.ceil((length - self.overlap) / self.step))

    def starts(self, count: int) -> np.ndarray:
        """Return where patches begin, (count,) int."""
        return np.rint(np.arange(count) * self.step).astype(int)


@dataclass(frozen=True, eq=False)
class Patches:
    """What a map is quilted from."""

    sources: list[np.ndarray]  #: (h, w, 3) uint8 each
    places: np.ndarray  #: (n, 3) int, source, row and column of each patch's corner
    #: (n, 3): number of the photo's plane that each patch was cut from, its middle there, px (x, y)
    middles: np.ndarray
    down: Cell
    across: Cell

    def pixels(self, number: int) -> np.ndarray:
        """Return a patch, (h, w, 3) uint8, a view."""
        source, row, column = self.places[number]
        return self.sources[source][row : row + self.down.side, column : column + self.across.side]


def quilted(patches: Patches, height: int, width: int, rng: np.random.Generator) -> np.ndarray:
    """Return a map (height, width, 3) uint8 of patches, which does not repeat.

    `rng` draws the first patch and breaks ties.
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
    grid = np.full((rows + 1, columns + 1), -1)  # with an empty row and column at the end
    tie = 0.05 * rng.random((rows, columns, count)).astype(np.float32)

    def best(i: int, j: int) -> int:
        cost = tie[i, j] + _S.worn * worn
        left, right, upper, lower = grid[i, j - 1], grid[i, j + 1], grid[i - 1, j], grid[i + 1, j]
        sides = ((left, beside), (upper, below), (right, beside.T), (lower, below.T))
        for neighbour, costs in sides:
            if neighbour >= 0:
                cost = cost + costs[neighbour]
        around = grid[max(0, i - _S.near) : i + _S.near + 1, max(0, j - _S.near) : j + _S.near + 1]
        taken = near[around[around >= 0]].max(axis=0, initial=0.0)
        return int((cost + _S.beside * taken).argmin())

    usual_wear = near.mean() * rows * columns
    near_worn = near / max(usual_wear, 1.0)
    for _ in range(1 + _S.sweeps):
        for i, j in np.ndindex(rows, columns):
            if grid[i, j] >= 0:
                worn -= near_worn[grid[i, j]]
                grid[i, j] = -1
            grid[i, j] = best(i, j)
            worn += near_worn[grid[i, j]]
    return grid[:rows, :columns]


def _alike(patches: Patches) -> np.ndarray:
    """Return the share of a patch's area that each other patch also shows, (n, n) float32."""
    apart = np.abs(patches.middles[:, None] - patches.middles[None])
    sides = np.array([patches.across.side, patches.down.side])
    shared = np.clip(1 - apart[..., 1:] / sides, 0, 1).prod(axis=2)
    return np.where(apart[..., 0] == 0, shared, 0.0).astype(np.float32)


def _fair(costs: np.ndarray) -> float:
    """Return the median cost of a patch beside a good neighbour: the one with ten better ones."""
    few = min(10, len(costs) - 1)
    return float(np.median(np.partition(costs, few, axis=1)[:, few]))


def _costs(patches: Patches) -> tuple[np.ndarray, np.ndarray]:
    """Return the costs (n, n) float32 of a patch (first index) left of another, and above it."""
    down, across = patches.down, patches.across
    scale = _S.strip / min(down.overlap, across.overlap)
    shape = (
        max(2 * _S.strip, round(across.side * scale)),
        max(2 * _S.strip, round(down.side * scale)),
    )
    numbers = range(len(patches.places))
    small = np.stack(
        [cv2.resize(patches.pixels(n), shape, interpolation=cv2.INTER_AREA) for n in numbers]
    ).astype(np.float32)
    # The strip that lies one step into a patch lies under the first strip of the next patch.
    x = min(round(across.step * shape[0] / across.side), shape[0] - _S.strip)
    y = min(round(down.step * shape[1] / down.side), shape[1] - _S.strip)
    return (
        _apart(small[:, :, x : x + _S.strip], small[:, :, : _S.strip]),
        _apart(small[:, y : y + _S.strip], small[:, : _S.strip]),
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
    """Return overlaps (..., h, w, 3) uint8: `upper` above a cut along w, `lower` below it."""
    shape = upper.shape
    upper, lower = (part.reshape(-1, *shape[-3:]) for part in (upper, lower))
    difference = upper.astype(np.float32) - lower
    cut, _ = cheapest_paths(np.einsum("nhwc,nhwc->wnh", difference, difference))
    down = np.arange(shape[-3], dtype=np.float32)[None, :, None]
    share = np.clip((down - cut.T[:, None, :]) / _S.feather + 0.5, 0.0, 1.0)[..., None]
    return np.rint(upper - share * difference).astype(np.uint8).reshape(shape)
