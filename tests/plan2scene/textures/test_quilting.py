"""Cuts between patches, and tiles quilted from periodic sources."""

import numpy as np
import pytest

from plan2scene.textures.quilting import Source, quilt


def test_quilt_of_a_periodic_source_is_the_source() -> None:
    wave = 2 * np.pi * np.arange(96) / 16
    image = np.repeat((0.5 + 0.2 * np.sin(wave)[:, None] * np.cos(wave))[..., None], 3, axis=2)
    valid = np.ones((96, 96), bool)
    valid[[0, -1]] = valid[:, [0, -1]] = False
    canvas = quilt([Source(image.astype(np.float32), valid)], 128)
    result = canvas.solve()
    np.testing.assert_allclose(result, np.roll(result, 16, axis=0), atol=1e-3)
    np.testing.assert_allclose(result, np.roll(result, 16, axis=1), atol=1e-3)
    assert result.std() == pytest.approx(image.std(), rel=0.01)


def test_quilted_joints_keep_the_step_that_the_periods_tell() -> None:
    """A patch shows one joint each way: nothing that it covers tells where the next one is."""
    image = np.random.default_rng(0).normal(0.6, 0.02, (38, 38, 3)).astype(np.float32)
    image[18:20] = image[:, 18:20] = 0.1
    made = quilt([Source(image, np.ones((38, 38), bool))], 64, (2, 2)).solve()
    for axis in (0, 1):
        line = made.mean(axis=(axis, 2))
        (dark,) = np.nonzero(line < line.mean() - 0.2)
        assert len(dark) == 4 and set(np.diff(dark)) == {1, 31}
