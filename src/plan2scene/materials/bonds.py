"""How units (planks, tiles, bricks) cover a periodic square: bonds and their geometry."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plan2scene.materials.periodic_noise import sample

_TABLE = 8192  # size of the table of per-unit random values


@dataclass(frozen=True)
class Layout:
    """Where each pixel lies in its unit."""

    key: np.ndarray  #: (n, n) int64, hash of the unit in [0, 8192)
    u: np.ndarray  #: (n, n) float32, metres from the unit's centre along its long side
    v: np.ndarray  #: along its short side
    edge: np.ndarray  #: (n, n) float32, metres to the unit's border
    size_m: float  #: side of the tile, metres

    @property
    def pixel(self) -> float:
        """Side of a pixel in metres."""
        return self.size_m / self.key.shape[0]

    def draw(self, rng: np.random.Generator, spread: float = 1.0) -> np.ndarray:
        """Return one normal value per unit, spread over its pixels: (n, n) float32."""
        return (rng.standard_normal(_TABLE, dtype=np.float32) * np.float32(spread))[self.key]

    def choose(self, rng: np.random.Generator, weights: np.ndarray) -> np.ndarray:
        """Return one index per unit drawn with `weights`: (n, n) int64."""
        return rng.choice(len(weights), _TABLE, p=weights / weights.sum())[self.key]

    def lookup(self, rng: np.random.Generator, image: np.ndarray) -> np.ndarray:
        """Return (n, n[, c]) where each unit shows a different part of a periodic image."""
        n = image.shape[0]
        offset_x, offset_y = rng.uniform(0, n, (2, _TABLE)).astype(np.float32)
        flip = np.where(rng.random(_TABLE) < 0.5, -1.0, 1.0).astype(np.float32)
        scale = np.float32(1.0 / self.pixel)
        x = self.u * scale * flip[self.key] + offset_x[self.key]
        y = self.v * scale + offset_y[self.key]
        return sample(image, x, y)

    def joint(self, width: float) -> np.ndarray:
        """Return the antialiased coverage of joints of `width` metres: (n, n) float32 in [0, 1]."""
        pixel = self.pixel
        half = max(width, pixel) / 2
        coverage = np.clip((half - self.edge) / pixel + 0.5, 0.0, 1.0)
        return (coverage * min(1.0, width / pixel)).astype(np.float32)


def _grid_positions(size: int) -> tuple[np.ndarray, np.ndarray]:
    """Return pixel centres x (1, n) and y (n, 1) in [0, 1)."""
    axis = (np.arange(size, dtype=np.float64) + 0.5) / size
    return axis[None, :], axis[:, None]


def _key(cx: np.ndarray, cy: np.ndarray) -> np.ndarray:
    """Return the hash of units from their centres on the torus of side 1."""
    kx = np.floor(np.mod(cx + 0.00137, 1.0) * 4001).astype(np.int64)
    ky = np.floor(np.mod(cy + 0.00173, 1.0) * 4001).astype(np.int64)
    mixed = kx * 73856093 + ky * 19349663
    return (mixed ^ (mixed >> 13)) & (_TABLE - 1)


def bond(
    size: int, columns: int, rows: int, size_m: float, offsets: np.ndarray, *, upright: bool = False
) -> Layout:
    """Return rows of units, each row shifted by its offset (in unit lengths).

    `columns` units of length size_m / columns in each of `rows` rows; `upright` turns the whole
    pattern by 90 degrees.
    """
    x, y = _grid_positions(size)
    row = np.floor(y * rows).astype(np.int64)
    shift = offsets[np.mod(row, rows)] / columns
    column = np.floor((x - shift) * columns)
    cx = (column + 0.5) / columns + shift
    cy = (row + 0.5) / rows + np.zeros_like(x)
    u, v = (x - cx) * size_m, (y - cy) * size_m
    edge = np.minimum(size_m / columns / 2 - np.abs(u), size_m / rows / 2 - np.abs(v))
    return _layout(cx, cy, u, v, edge, size_m, upright)


def diagonal_grid(size: int, count: int, size_m: float) -> Layout:
    """Return a square grid turned by 45 degrees, `count` diagonals per side (2 count^2 units)."""
    x, y = _grid_positions(size)
    p, q = count * (x + y), count * (x - y)
    cp, cq = np.floor(p) + 0.5, np.floor(q) + 0.5
    unit = size_m / (count * np.sqrt(2.0))
    u, v = (p - cp) * unit, (q - cq) * unit
    edge = unit / 2 - np.maximum(np.abs(u), np.abs(v))
    return _layout((cp + cq) / (2 * count), (cp - cq) / (2 * count), u, v, edge, size_m)


def herringbone(size: int, ratio: int, size_m: float, *, diagonal: bool) -> Layout:
    """Return a herringbone of blocks 1 x `ratio`; `diagonal` lays it at 45 degrees."""
    x, y = _grid_positions(size)
    if diagonal:
        p, q = ratio * (x + y), ratio * (x - y)
        unit = size_m / (ratio * np.sqrt(2.0))
    else:
        p, q = 2 * ratio * x + 0 * y, 2 * ratio * y + 0 * x
        unit = size_m / (2 * ratio)
    ip, iq = np.floor(p), np.floor(q)
    step = np.mod(ip - iq, 2 * ratio)
    flat = step < ratio
    cp = np.where(flat, ip - step + ratio / 2, ip + 0.5)
    cq = np.where(flat, iq + 0.5, iq - (2 * ratio - 1 - step) + ratio / 2)
    du, dv = (p - cp) * unit, (q - cq) * unit
    u, v = np.where(flat, du, dv), np.where(flat, dv, du)
    edge = np.minimum(ratio * unit / 2 - np.abs(u), unit / 2 - np.abs(v))
    if diagonal:
        cx, cy = (cp + cq) / (2 * ratio), (cp - cq) / (2 * ratio)
    else:
        cx, cy = cp / (2 * ratio), cq / (2 * ratio)
    return _layout(cx, cy, u, v, edge, size_m)


def basket(size: int, blocks: int, strips: int, size_m: float) -> Layout:
    """Return squares of `strips` parallel strips, turned by 90 degrees from square to square.

    `blocks` squares per side, an even number.
    """
    x, y = _grid_positions(size)
    x, y = x + 0 * y, y + 0 * x
    block = 1.0 / blocks
    bx, by = np.floor(x / block), np.floor(y / block)
    flat = np.mod(bx + by, 2) < 1
    lx, ly = x / block - bx, y / block - by
    across = np.where(flat, ly, lx)
    strip = (np.floor(across * strips) + 0.5) / strips
    cx = (bx + np.where(flat, 0.5, strip)) * block
    cy = (by + np.where(flat, strip, 0.5)) * block
    du, dv = (x - cx) * size_m, (y - cy) * size_m
    u, v = np.where(flat, du, dv), np.where(flat, dv, du)
    unit = size_m * block
    edge = np.minimum(unit / 2 - np.abs(u), unit / strips / 2 - np.abs(v))
    return _layout(cx, cy, u, v, edge, size_m)


def hexagons(size: int, columns: int, size_m: float, *, rounds: bool = False) -> Layout:
    """Return hexagons (or, with `rounds`, circles in the same places); `columns` per side."""
    x, y = _grid_positions(size)
    pairs = max(1, round(columns / np.sqrt(3.0)))
    width, height = 1.0 / columns, 1.0 / pairs
    grids = []
    for shift in (0.0, 0.5):
        cx = (np.floor(x / width - shift) + 0.5 + shift) * width + 0 * y
        cy = (np.floor(y / height - shift) + 0.5 + shift) * height + 0 * x
        dx, dy = (x - cx) / width, (y - cy) / height * np.sqrt(3.0)
        grids.append((dx * dx + dy * dy, cx, cy, dx, dy))
    nearer = grids[1][0] < grids[0][0]
    distance, cx, cy, dx, dy = (np.where(nearer, b, a) for a, b in zip(*grids, strict=True))
    unit = size_m * width
    if rounds:
        edge = (0.48 - np.sqrt(distance)) * unit
    else:
        skew = np.abs(dx) / 2 + np.abs(dy) * np.sqrt(3.0) / 2
        edge = (0.5 - np.maximum(np.abs(dx), skew)) * unit
    return _layout(cx, cy, dx * unit, dy * unit, edge, size_m)


def _layout(
    cx: np.ndarray,
    cy: np.ndarray,
    u: np.ndarray,
    v: np.ndarray,
    edge: np.ndarray,
    size_m: float,
    upright: bool = False,
) -> Layout:
    """Pack arrays into a Layout, turned by 90 degrees when `upright`."""
    arrays = (
        _key(*np.broadcast_arrays(cx, cy)),
        u.astype(np.float32) + 0 * v.astype(np.float32),
        v.astype(np.float32) + 0 * u.astype(np.float32),
        edge.astype(np.float32),
    )
    if upright:
        arrays = tuple(np.ascontiguousarray(a.T) for a in arrays)  # type: ignore[assignment]
    return Layout(*arrays, size_m=size_m)
