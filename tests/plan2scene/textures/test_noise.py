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


@pytest.fixture
def seeds() -> torch.Tensor:
    return torch.rand(3, 8, 3, generator=torch.Generator().manual_seed(4))
