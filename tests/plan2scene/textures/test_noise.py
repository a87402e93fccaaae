"""Noise values of the reference, and that the torus lattice repeats."""

import itertools

import numpy as np
import pytest
import torch

from plan2scene.textures.model import noise

# What the reference implementation returns on a CPU.
POSITIONS = [(0.3, -0.7), (1.5, 2.25), (-3.2, 0.01), (5.99, -6.4), (100.4, -37.3)]
SEEDS = [0.1, 0.5, 0.9, 0.33, 0.77]
NEAREST = [
    0.04466700553894043,
    0.2800705134868622,
    0.5416138172149658,
    0.9053457379341125,
    0.39467427134513855,
]
BILINEAR = [
    0.11319306492805481,
    0.3965536952018738,
    0.6032536029815674,
    0.8600621223449707,
    0.47674256563186646,
]


def test_values_of_the_reference() -> None:
    positions, seeds = torch.tensor(POSITIONS), torch.tensor(SEEDS)
    np.testing.assert_allclose(noise.nearest(positions, seeds), NEAREST, atol=1e-6)
    np.testing.assert_allclose(noise.bilinear(positions, seeds), BILINEAR, atol=1e-6)


def test_grids() -> None:
    grid = noise.position_grid(5, periodic=False)
    assert grid[0, 0].tolist() == [-1.0, -0.5, 0.0, 0.5, 1.0]
    assert grid[1, :, 0].tolist() == [1.0, 0.5, 0.0, -0.5, -1.0]
    assert noise.position_grid(4, periodic=True)[0, 0].tolist() == [-1.0, -0.5, 0.0, 0.5]


@pytest.fixture
def coefficients() -> torch.Tensor:
    return torch.randn(3, 32, generator=torch.Generator().manual_seed(3)) * 0.7


@pytest.fixture
def seeds() -> torch.Tensor:
    return torch.rand(3, 8, 3, generator=torch.Generator().manual_seed(4))


@pytest.mark.parametrize("shift", [(2.0, 0.0), (0.0, 2.0), (-2.0, 4.0)])
def test_torus_noise_repeats_over_the_tile(coefficients, seeds, shift) -> None:
    # Positions off the cell borders, where rounding decides between two cells.
    grid = noise.position_grid(32, periodic=True) + 0.00371
    moved = grid + torch.tensor(shift).view(2, 1, 1)
    here = noise.torus_noise(coefficients, seeds, grid)
    there = noise.torus_noise(coefficients, seeds, moved)
    assert ((here - there).abs() < 1e-3).float().mean() > 0.999
    assert here.shape == (3, 48, 32, 32)


def test_plane_noise_does_not_repeat(coefficients, seeds) -> None:
    grid = noise.position_grid(16, periodic=True) + 0.00371
    here = noise.plane_noise(coefficients, seeds, grid)
    there = noise.plane_noise(coefficients, seeds, grid + 2.0)
    assert ((here - there).abs() < 1e-3).float().mean() < 0.2


def test_torus_noise_is_uniform_and_depends_on_every_seed(coefficients, seeds) -> None:
    grid = noise.position_grid(64, periodic=True)
    maps = noise.torus_noise(coefficients, seeds, grid)
    fine = maps[:, 21:24]  # nearest, octave 7
    assert float(fine.min()) >= 0.0
    assert float(fine.max()) < 1.0
    assert float(fine.mean()) == pytest.approx(0.5, abs=0.03)
    assert float(fine.std()) == pytest.approx(12**-0.5, abs=0.02)
    for channel in range(3):
        other = seeds.clone()
        other[:, 7, channel] = (other[:, 7, channel] + 0.37) % 1
        changed = noise.torus_noise(coefficients, other, grid)[:, 21:24]
        assert ((changed - fine).abs() > 1e-3).float().mean() > 0.9
    correlation = torch.corrcoef(fine[0].flatten(1))
    assert float((correlation - torch.eye(3)).abs().max()) < 0.1


def test_no_deformation_gives_square_cells(seeds) -> None:
    maps = noise.torus_noise(torch.zeros(3, 32), seeds, noise.position_grid(16, periodic=True))
    first = maps[0, 0]  # octave 0: 2 x 2 cells over the tile
    assert len(first.unique()) <= 4
    assert len(maps[0, 9].unique()) > 40  # octave 3: 16 x 16 cells


@pytest.mark.parametrize("rows", [[[2, 1], [0, 3]], [[0, 2], [3, 0]], [[4, 6], [2, 3]]])
def test_triangular_basis_spans_the_same_lattice(rows) -> None:
    matrix = torch.tensor(rows).view(1, 1, 2, 2)
    a, b, d = (int(v) for v in noise._triangular_basis(matrix)[0, 0])
    span = range(-4, 5)

    def points(columns):
        sums = (
            (i * columns[0][0] + j * columns[1][0], i * columns[0][1] + j * columns[1][1])
            for i, j in itertools.product(range(-40, 41), repeat=2)
        )
        return {p for p in sums if p[0] in span and p[1] in span}

    original = points(list(zip(*rows, strict=True)))
    assert points([(a, b), (0, d)]) == original
    assert a >= 0
    assert d >= 0


def test_gradient_flows_through_the_bilinear_maps_only(seeds) -> None:
    coefficients = torch.zeros(3, 32, requires_grad=True)
    grid = noise.position_grid(16, periodic=True)
    maps = noise.torus_noise(coefficients, seeds, grid)
    (gradient,) = torch.autograd.grad(maps[:, 24:].square().sum(), coefficients, retain_graph=True)
    assert float(gradient.abs().max()) > 0
    assert not maps[:, :24].requires_grad or torch.equal(
        torch.autograd.grad(maps[:, :24].sum(), coefficients)[0], torch.zeros_like(coefficients)
    )


def _integer_hash(x: int, y: int, basis: tuple[int, int, int], offset: int) -> int:
    """Return the hash of a cell in Python's integers, which know no rounding."""
    a, b, d = basis
    turns = x // a if a else 0
    x, y = x - turns * a, y - turns * b
    y = y % d if d else y
    mask = 2**64 - 1

    def shift(value: int, bits: int) -> int:
        return (value >> bits) | ((mask << (64 - bits)) & mask if value >> 63 else 0)

    index = (x * 73856093 + y * 19349663 + offset) & mask
    for bits, factor in ((30, -4658895280553007687), (27, -7723592293110705685), (31, 1)):
        index = ((index ^ shift(index, bits)) * factor) & mask
    return index


def test_hash_is_that_of_whole_numbers() -> None:
    rng = np.random.default_rng(0)
    sizes = rng.integers(0, 2**18, (40, 3))
    sizes[:20, 0] = rng.integers(0, 4, 20)  # slim lattices: one turn of x is many of y
    sizes[35:, 2] = 0
    offsets = rng.integers(0, 2**52, 40)
    cells = rng.integers(-(2**10), 2**10, (40, 2, 8, 8))
    # Cells on the lattice's lines, and next to them.
    cells[:, 0, 0] = sizes[:, :1] * rng.integers(-3, 3, (40, 8)) + rng.integers(-1, 2, (40, 8))
    basis = torch.from_numpy(sizes).double().view(5, 8, 3)
    x, y = torch.from_numpy(cells).double().view(5, 8, 2, 8, 8).unbind(2)
    found = noise._hash(x, y, basis, torch.from_numpy(offsets).view(5, 8, 1, 1))
    assert found.shape == (5, 8, 3, 8, 8)
    for k, i, j in itertools.product(range(40), range(8), range(8)):
        place = (int(cells[k, 0, i, j]), int(cells[k, 1, i, j]))
        whole = _integer_hash(*place, tuple(map(int, sizes[k])), int(offsets[k]))
        values = [(whole >> 16 * channel & 0xFFFF) / 65536 for channel in range(3)]
        assert found[k // 8, k % 8, :, i, j].tolist() == values
