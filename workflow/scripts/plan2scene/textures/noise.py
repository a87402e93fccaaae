"""The decoder's noise: octaves of nearest and bilinear lattice noise over a transformed plane.

Two lattices share one interface. :func:`plane_noise` is the reference's (a hash of the lattice
position over the infinite plane, kept for imported checkpoints); :func:`torus_noise` repeats over
the tile by construction, so what is decoded from it has no seam (docs/conventions.md: a tile
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

    Parameters
    ----------
    position : (..., 2) float32
    seed : (...) float32
        Uniform in [0, 1); broadcasts against the positions.

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

    Parameters
    ----------
    grid : (2, h, w) float32
        Positions, a part of :func:`position_grid`.
    coefficients : (n, 32) float32
        Transform coefficients of the encoder (octave, row, column).
    seeds : (n, 8, 3) float32
        One number in [0, 1) per octave and colour channel.
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
    # A small turn moves the cells of octave i by 2^i: undamped, the finest octaves' gradients are
    # random and drown all others in the encoder.
    damping = 0.5 ** torch.arange(OCTAVES, dtype=matrices.dtype, device=matrices.device)
    sides = whole + (matrices - matrices.detach()) * damping.view(1, OCTAVES, 1, 1)
    position = torch.einsum("noij,jhw->noihw", sides, grid / 2.0)
    basis = _triangular_basis(whole.long())
    digits = (seeds.double() * (1 << _SEED_BITS)).long()
    offsets = (digits * digits.new_tensor([2654435761, 40503, 1])).sum(-1)[..., None, None]
    base = position.detach().floor().long()
    near = _hash(base[:, :, 0], base[:, :, 1], basis, offsets)
    shifted = position - 0.5
    corner = shifted.detach().floor()
    weight = (shifted - corner).unsqueeze(2)
    wx, wy = weight[:, :, :, 0], weight[:, :, :, 1]
    x, y = corner[:, :, 0].long(), corner[:, :, 1].long()
    lower = _mix(_hash(x, y, basis, offsets), _hash(x + 1, y, basis, offsets), wx)
    upper = _mix(_hash(x, y + 1, basis, offsets), _hash(x + 1, y + 1, basis, offsets), wx)
    smooth = _mix(lower, upper, wy)
    return torch.cat([near.flatten(1, 2), smooth.flatten(1, 2)], dim=1)


def _mix(a: torch.Tensor, b: torch.Tensor, weight: torch.Tensor) -> torch.Tensor:
    return a + (b - a) * weight


def _triangular_basis(matrix: torch.Tensor) -> torch.Tensor:
    """Return (a, b, d) stacked last: the lattice spanned by the columns is that of (a, b), (0, d).

    Euclid's algorithm on the columns of (n, octaves, 2, 2) integer matrices; a, d >= 0, and 0
    where the columns leave that direction free.
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


def _floor_quotient(value: torch.Tensor, divisor: torch.Tensor) -> torch.Tensor:
    """Return value // max(divisor, 1) of int64 below 2^50, through float64: twice as fast.

    Exact: the quotient of integers is at least 1 / divisor away from the next whole number, which
    is more than its rounding.
    """
    return torch.floor(value / divisor.clamp(min=1).double()).long()


def _hash(
    x: torch.Tensor, y: torch.Tensor, basis: torch.Tensor, offsets: torch.Tensor
) -> torch.Tensor:
    """Return values in [0, 1), (n, octaves, channels, h, w), of integer cells modulo the basis.

    Integer arithmetic only, so every platform returns the same; the channels are bit fields of
    one 64-bit hash (splitmix64's mixing steps).
    """
    a, b, d = (part[..., None, None] for part in basis.unbind(-1))
    turns = torch.where(a > 0, _floor_quotient(x, a), 0)
    x, y = x - turns * a, y - turns * b
    y = torch.where(d > 0, y - _floor_quotient(y, d) * d, y)
    index = x * 73856093 + y * 19349663 + offsets
    index = (index ^ (index >> 30)) * -4658895280553007687
    index = (index ^ (index >> 27)) * -7723592293110705685
    index = index ^ (index >> 31)
    bits = [(index >> shift) & 0xFFFF for shift in (0, 16, 32)]
    return torch.stack(bits, dim=2).float() / 65536.0
