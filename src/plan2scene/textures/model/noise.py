"""The decoder's noise: octaves of nearest and bilinear lattice noise over a transformed plane.

Two lattices share one interface. :func:`plane_noise` is the reference's: a hash of the lattice
position over the infinite plane, kept for imported checkpoints. :func:`torus_noise` repeats over
the tile by construction, so a texture decoded from it has no seam (docs/conventions.md: a tile
repeats). Positions are in [-1, 1] x [-1, 1], x right, y up; the tile is that square.
"""

from __future__ import annotations

import torch

#: Octaves of noise and colour channels per octave.
OCTAVES, CHANNELS = 8, 3
_GOLDEN = 0.1618033988749895
_PI = 0.3141592653589793
_SCALE = 14142.135623730951
_SEED_BITS = 20


def position_grid(size_px: int, *, periodic: bool) -> torch.Tensor:
    """Return the (2, size, size) float32 grid of x (right) and y (up) positions.

    The reference samples both ends of [-1, 1]; a periodic grid leaves the last one out, because
    it is the first of the next tile.
    """
    if periodic:
        line = torch.arange(size_px, dtype=torch.float32) * (2.0 / size_px) - 1.0
    else:
        line = torch.linspace(-1.0, 1.0, size_px)
    y, x = torch.meshgrid(-line, line, indexing="ij")
    return torch.stack([x, y])


def octave_matrices(coefficients: torch.Tensor) -> torch.Tensor:
    """Return 2^i (I + T_i), (n, octaves, 2, 2), of the encoder's (n, octaves * 4) coefficients."""
    shift = coefficients.view(-1, OCTAVES, 2, 2)
    identity = torch.eye(2, dtype=shift.dtype, device=shift.device)
    scale = 2.0 ** torch.arange(OCTAVES, dtype=shift.dtype, device=shift.device)
    return scale.view(1, OCTAVES, 1, 1) * (identity + shift)


def nearest(position: torch.Tensor, seed: torch.Tensor) -> torch.Tensor:
    """Return the reference's hash in [0, 1) of the lattice cell that holds each position.

    Positions are (..., 2) float32; the seed (...), uniform in [0, 1), broadcasts against them.
    Computed in float64: the hash takes the fractional part of a large tangent.
    """
    cell = position.double().floor()
    anchor = torch.tensor([_GOLDEN, _PI], dtype=torch.float64, device=position.device)
    spread = (seed.double() + _GOLDEN).unsqueeze(-1)
    distance = torch.sqrt(1e-8 + ((cell * spread - anchor) ** 2).sum(-1))
    value = _SCALE * torch.tan(distance)
    return (value - value.floor()).float()


def bilinear(position: torch.Tensor, seed: torch.Tensor) -> torch.Tensor:
    """Return :func:`nearest` interpolated between the four cells around each position."""
    shifted = position - 0.5
    weight = shifted - shifted.floor()
    wx, wy = weight[..., 0], weight[..., 1]
    corners = [
        nearest(position + position.new_tensor([dx, dy]), seed)
        for dx in (-0.5, 0.5)
        for dy in (-0.5, 0.5)
    ]
    left = corners[0] * (1 - wy) + corners[1] * wy
    right = corners[2] * (1 - wy) + corners[3] * wy
    return left * (1 - wx) + right * wx


def plane_noise(
    coefficients: torch.Tensor, seeds: torch.Tensor, grid: torch.Tensor
) -> torch.Tensor:
    """Return the reference's noise maps (n, 48, h, w): 24 nearest, then 24 bilinear.

    `coefficients` (n, 32) are the encoder's (octave, row, column), `seeds` (n, 8, 3) one number in
    [0, 1) per octave and colour channel, `grid` (2, h, w) a part of :func:`position_grid`; float32.
    """
    position = torch.einsum("noij,jhw->nohwi", octave_matrices(coefficients), grid).unsqueeze(2)
    seed = seeds.view(-1, OCTAVES, CHANNELS, 1, 1)
    position = position.expand(-1, -1, CHANNELS, -1, -1, -1)
    with torch.no_grad():
        near = nearest(position, seed)
    maps = torch.cat([near.flatten(1, 2), bilinear(position, seed).flatten(1, 2)], dim=1)
    return maps


def torus_noise(
    coefficients: torch.Tensor, seeds: torch.Tensor, grid: torch.Tensor
) -> torch.Tensor:
    """Return noise maps (n, 48, h, w) that repeat over the tile: 24 nearest, then 24 bilinear.

    Each octave's matrix is rounded so that the tile's sides are whole lattice vectors, and lattice
    cells are hashed modulo these vectors. The rounding passes gradients straight through, damped
    by the octave's scale. More pixels sample the same noise more finely. Parameters as of
    :func:`plane_noise`.
    """
    matrices = 2.0 * octave_matrices(coefficients)  # columns: the tile's sides in lattice cells
    whole = matrices.detach().round()
    # A small rotation moves the cells of octave i by 2^i. Without damping, the finest octaves'
    # gradients would be random and hide all others in the encoder.
    damping = 0.5 ** torch.arange(OCTAVES, dtype=matrices.dtype, device=matrices.device)
    sides = whole + (matrices - matrices.detach()) * damping.view(1, OCTAVES, 1, 1)
    position = torch.einsum("noij,jhw->noihw", sides, grid / 2.0)
    shifted = position - 0.5
    corner = shifted.detach().floor()
    wx, wy = (shifted - corner).unsqueeze(3).unbind(2)
    with torch.no_grad():
        basis = _triangular_basis(whole.long()).double()
        digits = (seeds.double() * (1 << _SEED_BITS)).long()
        offsets = (digits * digits.new_tensor([2654435761, 40503, 1])).sum(-1)[..., None, None]
        x, y = corner.double().unbind(2)
        (a, b), (c, d) = (
            [_hash(x + right, y + up, basis, offsets) for right in (0, 1)] for up in (0, 1)
        )
        # The cell that holds a position is one of the four that it is interpolated between.
        right, up = wx >= 0.5, wy >= 0.5
        near = torch.where(up, torch.where(right, d, c), torch.where(right, b, a))
    smooth = torch.lerp(torch.lerp(a, b, wx), torch.lerp(c, d, wx), wy)
    return torch.cat([near.flatten(1, 2), smooth.flatten(1, 2)], dim=1)


def _triangular_basis(matrix: torch.Tensor) -> torch.Tensor:
    """Return (a, b, d) stacked last: (a, b) and (0, d) span the same lattice as the columns.

    Euclid's algorithm on the columns of (n, octaves, 2, 2) integer matrices. a, d >= 0; they are 0
    where the columns do not span that direction.
    """
    x1, y1 = matrix[..., 0, 0].clone(), matrix[..., 1, 0].clone()
    x2, y2 = matrix[..., 0, 1].clone(), matrix[..., 1, 1].clone()
    while bool((x2 != 0).any()):
        live = x2 != 0
        quotient = torch.where(
            live, torch.div(x1, torch.where(live, x2, 1), rounding_mode="floor"), 0
        )
        rest_x, rest_y = x1 - quotient * x2, y1 - quotient * y2
        x1, x2 = torch.where(live, x2, x1), torch.where(live, rest_x, x2)
        y1, y2 = torch.where(live, y2, y1), torch.where(live, rest_y, y2)
    sign = torch.where(x1 < 0, -1, 1)
    return torch.stack([x1 * sign, y1 * sign, y2.abs()], dim=-1)


def _hash(
    x: torch.Tensor, y: torch.Tensor, basis: torch.Tensor, offsets: torch.Tensor
) -> torch.Tensor:
    """Return values in [0, 1), (n, octaves, channels, h, w), of whole cells modulo the basis.

    Cells and basis are float64, which divides faster than int64. The division is exact here: a
    quotient that is no whole number is at least 1 / divisor away from one, more than its rounding
    error. The hash is integer arithmetic, so every platform returns the same values. The channels
    are bit fields of one 64-bit hash (splitmix64's mixing steps).
    """
    a, b, d = (part[..., None, None] for part in basis.unbind(-1))
    # A direction that the columns do not span does not wrap around: its number of turns is 0.
    turns = (x / torch.where(a > 0, a, torch.inf)).floor_()
    x, y = torch.addcmul(x, turns, a, value=-1), torch.addcmul(y, turns, b, value=-1)
    y.addcmul_((y / torch.where(d > 0, d, torch.inf)).floor_(), d, value=-1)
    index = (x * 73856093).add_(y, alpha=19349663).long().add_(offsets)
    index.bitwise_xor_(index >> 30).mul_(-4658895280553007687)
    index.bitwise_xor_(index >> 27).mul_(-7723592293110705685)
    index.bitwise_xor_(index >> 31)
    n, octaves, h, w = index.shape
    values = torch.empty((n, octaves, CHANNELS, h, w), device=index.device)
    for channel in range(CHANNELS):
        values[:, :, channel] = (index >> 16 * channel).bitwise_and_(0xFFFF)
    return values.mul_(1.0 / 65536.0)
