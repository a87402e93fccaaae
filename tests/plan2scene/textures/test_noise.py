"""Noise values of the reference, and that the torus lattice repeats."""

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


def test_gradient_flows_through_the_bilinear_maps_only(seeds) -> None:
    coefficients = torch.zeros(3, 32, requires_grad=True)
    grid = noise.position_grid(16, periodic=True)
    maps = noise.torus_noise(coefficients, seeds, grid)
    (gradient,) = torch.autograd.grad(maps[:, 24:].square().sum(), coefficients, retain_graph=True)
    assert float(gradient.abs().max()) > 0
    assert not maps[:, :24].requires_grad or torch.equal(
        torch.autograd.grad(maps[:, :24].sum(), coefficients)[0], torch.zeros_like(coefficients)
    )
