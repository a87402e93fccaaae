from dataclasses import replace

import cv2
import numpy as np
import pytest

from plan2scene.plans.surface_areas import Area
from plan2scene.textures.laying import LAYING, LaidPattern, laid, laid_tile, with_joints

WHITE = np.full(3, 0.5)


def pattern(direction, *, length=0.5):
    """Return a pattern of ten units of one tone each, with dark joints of 1 cm."""
    units = [np.full((50, 100, 3), 110 + 4 * k, np.uint8) for k in range(10)]
    return LaidPattern("planks", 0.25, length, direction, 0.5, np.full(3, 0.9), 0.01, units)


@pytest.mark.parametrize("direction", [0.0, 90.0])
def test_joints_are_the_patterns(direction):
    image, _ = laid(pattern(direction), Area((-0.5, -0.5), (1.0, 1.0)), WHITE, seed=1)
    if direction:
        image = image.swapaxes(0, 1)
    assert pattern(direction).words == "planks 25 x 50 cm"
    dark = image[..., 0] < 60
    rows = np.flatnonzero(dark.mean(axis=1) > 0.9) / LAYING.px_per_m - 0.5
    assert np.abs(rows / 0.25 - np.round(rows / 0.25)).max() < 0.04
    assert len(np.unique(np.round(rows / 0.25))) >= 6
    ends = np.flatnonzero(dark[20:40].all(axis=0)) / LAYING.px_per_m
    assert np.diff(ends[np.r_[True, np.diff(ends) > 0.1]]) == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize("length", [0.5, float("nan")])
@pytest.mark.parametrize("direction", [0.0, 30.0])
def test_a_floor_runs_on_from_room_to_room(direction, length):
    planks = pattern(direction, length=length)
    whole, _ = laid(planks, Area((-1.0, 0.0), (2.0, 1.0)), WHITE, seed=1)
    everywhere = Area((-1.0, 0.0), (2.0, 1.0))
    part, area = laid(planks, Area((0.5, 0.25), (2.0, 1.0)), WHITE, 1, everywhere)
    assert area == Area((0.5, 0.25), (2.0, 1.0))
    column, row = (round(metres * LAYING.px_per_m) for metres in (1.5, 0.25))
    shown = whole[row : row + part.shape[0], column:].astype(int)
    assert np.abs(shown - part)[2:-2, 2:-2].max() <= 2 and len(np.unique(part[..., 0])) > 8


@pytest.mark.parametrize("kind", ["herringbone", "chevron"])
def test_planks_in_columns_are_laid_whole_and_run_on(kind):
    units = [np.full((20, 80, 3), 60 + 3 * k, np.uint8) for k in range(40)]
    floor = LaidPattern(kind, 0.1, 0.4, 0.0, 0.0, np.zeros(3), 0.0, units, "", 45.0)
    everywhere = Area((0.0, 0.0), (2.0, 2.0))
    whole, _ = laid(floor, everywhere, WHITE, seed=1)
    part, _ = laid(floor, Area((1.0, 0.5), (2.0, 2.0)), WHITE, 1, everywhere)
    row, column = (round(metres * LAYING.px_per_m) for metres in (0.5, 1.0))
    assert (whole[row:, column:] == part).mean() > 0.99
    # A plank is 0.04 square metres of one tone; one and the same is a few times in 4.
    _, count = np.unique(whole[..., 0], return_counts=True)
    assert count.max() < 6 * 0.04 * LAYING.px_per_m**2
    # Along a plank the tone stays, across it changes.
    turned = [np.diagonal(whole[..., 0].astype(int), k)[:256] for k in (0, 256)]
    runs = [np.diff(np.flatnonzero(np.diff(line))) for line in turned]
    assert max(run.max() for run in runs) == pytest.approx(0.4 * 256 / 2**0.5, rel=0.1)


@pytest.mark.parametrize(
    ("kind", "length"),
    [("planks", 0.5), ("planks", float("nan")), ("herringbone", 0.4), ("chevron", 0.4)],
)
@pytest.mark.parametrize("direction", [0.0, 90.0])
def test_a_tile_of_whole_units_repeats_without_a_seam(kind, length, direction):
    units = [np.full((20, 100, 3), 60 + 3 * k, np.uint8) for k in range(40)]
    slant = 0.0 if kind == "planks" else 45.0
    floor = LaidPattern(kind, 0.1, length, direction, 0.5, np.zeros(3), 0.0, units, "", slant)
    tile, size_m = laid_tile(floor, 1.1, 256, WHITE, seed=1)
    assert tile.shape == (256, 256, 3) and size_m == pytest.approx(1.1, rel=0.3)
    if direction:
        tile = tile.swapaxes(0, 1)
    grey = tile[..., 0].astype(int)
    for image in (grey, grey.T):  # as rough over the border as inside
        steps = np.abs(np.diff(image, axis=0)).mean(axis=1)
        assert np.abs(image[0] - image[-1]).mean() <= 1.05 * steps.max()
    # A plank over the border is one plank: no piece is smaller.
    plank = 0.1 * (length if np.isfinite(length) else 0.25) * (256 / size_m) ** 2
    twice = np.tile(grey, (2, 2))
    sizes = np.zeros(twice.shape)
    for tone in np.unique(twice):
        same = (twice == tone).astype(np.uint8)
        _, labels, stats, _ = cv2.connectedComponentsWithStats(same, connectivity=4)
        sizes = np.where(same, stats[labels, cv2.CC_STAT_AREA], sizes)
    for seam in (sizes[256, 64:-64], sizes[64:-64, 256]):
        assert (seam >= 0.6 * plank).mean() > 0.75


def test_no_unit_is_laid_twice_within_sight():
    # Square tiles of 25 cm, forty tones: the plan's tones tell where each lies.
    units = [np.full((50, 50, 3), 60 + 3 * k, np.uint8) for k in range(40)]
    tiles = LaidPattern("tiles", 0.25, 0.25, 0.0, 0.0, np.zeros(3), 0.0, units)
    image, _ = laid(tiles, Area((0.0, 0.0), (4.0, 3.0)), WHITE, seed=3)
    step = round(0.25 * LAYING.px_per_m)
    shown = image[step // 2 :: step, step // 2 :: step, 0].astype(int)
    assert len(np.unique(shown)) == 40
    for tone in np.unique(shown):
        places = np.argwhere(shown == tone) * 0.25
        apart = np.hypot(*(places[:, None] - places[None]).T)
        assert apart[apart > 0].min(initial=9.0) >= 0.75


def test_joints_lie_over_a_floor_without_whole_units():
    area = Area((-0.5, -0.5), (1.0, 1.0))
    tiles = replace(pattern(0.0), units=[])
    floor = np.random.default_rng(1).integers(90, 170, (60, 60, 3)).astype(np.uint8)
    image, covered = with_joints(tiles, floor, area)
    assert covered == area
    plain, _ = laid(replace(tiles, units=[np.full((9, 9, 3), 128, np.uint8)]), area, WHITE, 0)
    joint = plain[..., 0] < 60
    assert image[joint].max() < 60 and image[~joint].min() > 60
    fine = cv2.resize(floor, image.shape[1::-1], interpolation=cv2.INTER_LINEAR)
    assert np.abs(image[~joint].astype(int) - fine[~joint]).mean() < 2
