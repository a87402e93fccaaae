import numpy as np
import pytest

from plan2scene.colour import delta_e_2000, median_colour, rgb_to_lab
from plan2scene.metrics.color_freq_tile import color_distance
from plan2scene.paint.shading import log_luma
from plan2scene.textures.exemplar.lattice import find_lattice
from plan2scene.textures.exemplar.make import ExemplarCrop, alike, calm, make_exemplar
from plan2scene.textures.seams import wrap_ratio
from plan2scene_workshop.texture.degradation import Degradation, degrade, window


def grid(columns, rows, *, bond=0.0, size=128, seed=0):
    rng = np.random.default_rng(seed)
    y, x = (np.mgrid[:size, :size] + 0.5) / size
    row = np.floor(y * rows).astype(int)
    u = (x * columns + bond * row) % columns
    v = y * rows - row
    shade = rng.normal(0.0, 6.0, (rows, columns))[row, np.floor(u).astype(int)]
    near = np.minimum(np.minimum(u % 1, 1 - u % 1) / columns, np.minimum(v, 1 - v) / rows)
    joint = (near * size < 1.2)[..., None]
    tile = np.array([150.0, 95.0, 80.0]) + shade[..., None] + rng.normal(0, 3, (size, size, 1))
    return np.clip(np.where(joint, 215.0, tile), 0, 255).astype(np.uint8)


def steepest_line(tile):
    values = tile.astype(float)
    steps = [np.abs(values - np.roll(values, 1, axis)).mean((1 - axis, 2)) for axis in (0, 1)]
    return max(step.max() for step in steps)


def detail(tile):
    return np.abs(np.diff(tile.astype(float), axis=0)).mean()


def crops_of(tile, seed=0, **changes):
    crops = degrade(tile, seed, how=Degradation(**changes))
    return [ExemplarCrop(crop.image, 2.0 * crop.side, crop.side) for crop in crops]


@pytest.mark.parametrize(("columns", "rows", "bond"), [(5, 5, 0.0), (4, 8, 0.5)])
def test_regular_patterns_are_cut_at_whole_periods(columns, rows, bond):
    tile = grid(columns, rows, bond=bond)
    made = make_exemplar(crops_of(tile), size_px=128)
    cut = made.pattern.cut
    assert (cut.columns, cut.rows) in {(columns, rows), (columns, rows // (2 if bond else 1))}
    assert made.size_m == pytest.approx(2.0, rel=0.03) and wrap_ratio(made.image) < 1.1
    assert steepest_line(made.image) < 1.2 * steepest_line(tile)  # no seam within it either
    away = delta_e_2000(rgb_to_lab(median_colour(made.image)), rgb_to_lab(median_colour(tile)))
    assert away < 3.0


def test_stripes_of_sun_on_few_crops_are_no_pattern_and_those_of_all_are_one():
    carpet = np.random.default_rng(0).integers(60, 80, (128, 128, 3), dtype=np.uint8)
    sunny = carpet.copy()
    sunny[(np.arange(128) // 16) % 2 == 0] += 60
    plain, striped = (ExemplarCrop(image, 0.5, 1.0) for image in (carpet, sunny))
    assert calm([plain, striped, plain]) == [plain, plain]
    assert calm([plain, striped, striped]) == [plain, striped, striped]


def test_poor_crops_make_no_exemplar_and_one_of_unknown_scale_is_enough():
    tile = grid(5, 5)
    assert make_exemplar([], size_px=128) is None
    assert make_exemplar([ExemplarCrop(tile, 1.0, 0.1)], size_px=128) is None
    burned = np.full((128, 128, 3), 255, np.uint8)
    assert make_exemplar([ExemplarCrop(burned, 1.0, 1.0)], size_px=128) is None
    noise = np.random.default_rng(1).normal(128, 20, (128, 128, 3))
    image = np.clip(noise + np.linspace(-30, 30, 128)[:, None, None], 0, 255).astype(np.uint8)
    made = make_exemplar([ExemplarCrop(image, float("nan"), float("nan"))], size_px=64)
    assert made.image.shape == (64, 64, 3) and np.isnan(made.size_m)
    assert wrap_ratio(made.image) < 1.3 < wrap_ratio(image)


@pytest.mark.parametrize("angle", [-20.0, 2.5, 31.0])
def test_lattice_of_a_turned_grid(angle):
    view = window(grid(6, 4), np.array([0.3, 0.6]), 0.9, angle) / 255.0
    found = find_lattice(log_luma(view), np.zeros((128, 128), bool))
    assert found.clear and found.angle_deg == pytest.approx(-angle, abs=0.6)
    step = 128 / 0.9
    assert found.periods == pytest.approx((step / 6, step / 4), rel=0.02)


def test_larger_tiles_show_more_metres_at_the_same_detail():
    tile = grid(5, 5)
    crops = crops_of(tile)
    small, large = (make_exemplar(crops, size_px=size) for size in (128, 256))
    assert large.image.shape == (256, 256, 3)
    assert large.size_m == pytest.approx(2 * small.size_m, rel=0.01)
    few, many = small.pattern.cut, large.pattern.cut
    assert (many.columns, many.rows) == (2 * few.columns, 2 * few.rows)
    # An enlargement would halve the steps from pixel to pixel.
    assert detail(large.image) == pytest.approx(detail(small.image), rel=0.15)
    assert color_distance(large.image, np.tile(small.image, (2, 2, 1))) < 0.1
    for made in (small, large):
        assert wrap_ratio(made.image) < 1.1
        assert steepest_line(made.image) < 1.2 * steepest_line(tile)


def test_of_two_paints_the_surface_s_own_colour_decides():
    rng = np.random.default_rng(3)

    def paint(colour):
        noise = rng.normal(0, 3, (128, 128, 3))
        return ExemplarCrop(np.clip(noise + colour, 0, 255).astype(np.uint8), 1.0, 1.0)

    white, green = ([paint(c) for _ in range(4)] for c in ((240, 240, 232), (108, 122, 103)))
    tone = np.array([0.42, 0.47, 0.41])
    assert alike([*white, *green], tone) == green
    assert alike([*white, *green], np.array([1.0, 1.0, 0.98])) == white
    made = make_exemplar([*white, *green], size_px=128, tone=tone)
    assert len(made.crops) == 4
    assert np.abs(np.median(made.image, axis=(0, 1)) - (108, 122, 103)).max() < 6
