import numpy as np
import pytest

from plan2scene.colour import as_uint8, linear_to_srgb
from plan2scene.photos.patterns.bands import BANDS, WallView, find_bands, read_step

PAINT, TILES = np.array([0.8, 0.78, 0.7]), np.array([0.3, 0.45, 0.5])
HEIGHT_M = 2.5


def wall(split, seed, *, left=0.0):
    """Return a wall of tiles up to `split`, and its mask: furniture hides a corner."""
    scale = BANDS.px_per_m
    rows, columns = round(HEIGHT_M * scale), round(2.4 * scale)
    image = np.tile(PAINT, (rows, columns, 1))
    below, right = round((HEIGHT_M - split) * scale), round(left * scale)
    image[below:, right:] = TILES
    image[below:, right::8] *= 0.8
    light = np.linspace(1, 0.5, columns)[None, :] * np.linspace(1.1, 0.6, rows)[:, None]
    noise = np.random.default_rng(seed).normal(0, 0.03, image.shape)
    seen = np.clip(image * light[..., None] * np.exp(noise), 0, 1)
    mask = np.ones((rows, columns), bool)
    mask[round(1.6 * scale) :, : round(0.8 * scale)] = False
    return as_uint8(linear_to_srgb(seen)), mask


def view(photo, split, *, left=0.0, scale=1.0):
    image, mask = wall(split, photo, left=left)
    mask[round((HEIGHT_M - split) * BANDS.px_per_m) - 8 :][:16, ::2] = False  # as masks do
    seen = list(read_step(image, mask, HEIGHT_M))
    seen[0] *= scale
    return WallView(f"{photo}.jpg", "bath", f"wall/{photo}_0", 1.5, scale == 1.0, *seen)


def test_bands_part_where_photos_show_it_and_up_to_a_doors_head_only_in_a_bath():
    found = find_bands([view(1, 1.2), view(2, 1.25), view(3, 1.2), view(4, 1.2, scale=0.8)])["bath"]
    assert found.split_m == pytest.approx(1.215, abs=0.04)
    assert found.lower / found.upper == pytest.approx(TILES / PAINT, rel=0.15)
    assert set(found.planes) == {f"wall/{k}_0" for k in range(1, 5)}
    views = [view(k, 1.9) for k in range(1, 4)]
    assert find_bands(views) == {}
    assert find_bands(views, {"bath"})["bath"].split_m == pytest.approx(1.9, abs=0.05)


@pytest.mark.parametrize(
    "views",
    [
        [view(1, 0.0), view(2, 0.0)],  # light alone
        [view(1, 1.2)],  # one wall in one photo
        [view(1, 1.2), view(2, 1.6)],  # things on two walls
        [view(1, 1.2), view(2, 1.2), *(view(k, 0.0) for k in range(3, 7))],  # one wall of four
        [view(1, 1.2, left=1.2), view(2, 1.2, left=1.2)],  # half a wall: a thing before it
    ],
    ids=["plain", "one view", "two heights", "few walls", "half a wall"],
)
def test_what_is_no_band_all_around_is_none(views):
    assert find_bands(views) == {}
