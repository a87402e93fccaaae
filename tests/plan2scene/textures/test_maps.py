from dataclasses import replace

import numpy as np
import pytest

from plan2scene.colour import median_colour
from plan2scene.house import SurfaceKey
from plan2scene.images import image_from_bytes, jpeg_bytes
from plan2scene.mesh.assembly import assemble
from plan2scene.mesh.texture_files import load_textures
from plan2scene.paint.shading import log_luma
from plan2scene.textures.exemplar.lattice import find_lattice
from plan2scene.textures.exemplar.make import ExemplarCrop, make_exemplar
from plan2scene.textures.house_textures import write_tiles
from plan2scene.textures.laying import LaidPattern
from plan2scene.textures.maps import cut_patches, detail_of_pattern, house_maps
from plan2scene.textures.quilting import quilted
from plan2scene.textures.tiles import Tile

SIDE = 128


def carpet(seed, side=SIDE):
    values = np.random.default_rng(seed).normal(0, 14, (side, side, 1))
    return np.clip(np.array([120, 100, 80]) + values, 0, 255).astype(np.uint8)


def slabs(seed, shift=0.0, count=4, side=SIDE):
    rng = np.random.default_rng(seed)
    place = (np.arange(side) + 0.5) / side * count + shift
    row, column = np.floor(place).astype(int), place % 1
    shade = rng.normal(0, 10, (count + 1, count + 1))[row[:, None], row[None, :]]
    joint = (column < 0.06)[:, None] | (column < 0.06)[None, :]
    grey = np.where(joint, 60.0, 170.0 + shade) + rng.normal(0, 2, (side, side))
    return np.repeat(np.clip(grey, 0, 255).astype(np.uint8)[..., None], 3, 2)


def exemplar(images, size_m=1.0, **facts):
    return make_exemplar([ExemplarCrop(i, size_m, 1.0, **facts) for i in images], size_px=128)


def tile_of(made, image=None):
    image = made.image if image is None else image
    return Tile(image, made.size_m, "test", True, pattern=made.pattern)


def quilt_of(detail, metres, seed=0):
    rng = np.random.default_rng(seed)
    patches = cut_patches(detail, rng)
    side = round(metres * detail.px_per_m)
    return quilted(patches, side, side, rng)


@pytest.fixture(scope="module")
def floor():
    return exemplar([carpet(k) for k in range(4)])


@pytest.fixture(scope="module")
def rug(floor):
    """The floor's exemplar as if photographed from afar: maps of few pixels."""
    crops = [replace(crop, sharpness=0.3) for crop in floor.pattern.crops]
    return replace(floor, pattern=replace(floor.pattern, crops=crops))


def test_a_map_does_not_repeat_where_its_tile_does(floor):
    detail = detail_of_pattern(floor.pattern, floor.size_m)
    image = quilt_of(detail, 3.0)
    assert image.shape == (round(3 * detail.px_per_m),) * 2 + (3,)
    # Moved by the tile's width a surface of tiles is the same, the map is not.
    grey = log_luma(image)
    moved = round(floor.size_m * detail.px_per_m)
    assert np.corrcoef(grey[:, moved:].ravel(), grey[:, :-moved].ravel())[0, 1] < 0.5
    assert image.std() == pytest.approx(floor.image.std(), rel=0.15)
    np.testing.assert_array_equal(image, quilt_of(detail, 3.0))


def test_slabs_stay_whole():
    made = exemplar([slabs(k, shift=0.23 * k) for k in range(5)])
    detail = detail_of_pattern(made.pattern, made.size_m)
    period = 0.25 * detail.px_per_m
    assert detail.periods == pytest.approx((period, period), rel=0.04)
    image = quilt_of(detail, 2.5)
    found = find_lattice(log_luma(image[:SIDE, :SIDE] / 255.0), np.zeros((SIDE, SIDE), bool))
    assert found.periods == pytest.approx(detail.periods, rel=0.05)
    assert np.sort((image[..., 0] < 115).mean(axis=0))[-9] > 0.8


def test_maps_are_as_fine_as_the_photos_and_no_finer(floor):
    assert detail_of_pattern(floor.pattern, floor.size_m).resolved == pytest.approx(SIDE)
    fine = jpeg_bytes(carpet(9, 256), quality=95, full_colour=True)
    crops = [replace(c, sharpness=2.0, detail=fine) for c in floor.pattern.crops]
    detail = detail_of_pattern(replace(floor.pattern, crops=crops), floor.size_m)
    assert detail.resolved == pytest.approx(256) and detail.px_per_m == pytest.approx(256)
    assert np.abs(np.diff(detail.sources[0].image, axis=0)).mean() > 0.03
    blurred = [replace(c, sharpness=0.5) for c in floor.pattern.crops]
    coarse = detail_of_pattern(replace(floor.pattern, crops=blurred), floor.size_m)
    assert coarse.px_per_m == pytest.approx(0.6 * SIDE)


def test_maps_of_a_house_cover_its_faces_in_the_tiles_colours(rug, gap_house, tmp_path):
    keys = gap_house.surface_keys()
    red = np.clip(rug.image * [1.3, 0.7, 0.7], 0, 255).astype(np.uint8)
    tiles = {key: tile_of(rug, red if key.room_id == "b" else None) for key in keys}
    maps = house_maps(gap_house, tiles, {}, {}, seed=1)
    assert set(maps) == set(keys)
    parts = assemble(gap_house).parts
    for key in keys:
        apart = median_colour(image_from_bytes(maps[key].jpeg)) - median_colour(tiles[key].image)
        assert np.abs(apart).max() < 0.02
    write_tiles(tmp_path / "t", "exemplar", [_Known(key) for key in keys], tiles, maps)
    textures = load_textures(tmp_path / "t", gap_house)
    for part in parts:
        if part.surface is not None and part.uv is not None:
            turns = textures[part.surface].turns(part.uv)
            assert turns.min() > 0 and turns.max() < 1
    floor = SurfaceKey("a", "floor")
    grid = LaidPattern("tiles", 0.4, 0.4, 0.0, 0.0, np.ones(3), 0.02, [])
    tiled = house_maps(gap_house, tiles, {}, {floor: grid}, seed=1)
    dark = [(image_from_bytes(m[floor].jpeg).max(axis=2) < 40).mean() for m in (maps, tiled)]
    assert tiled[floor].pattern == grid.words and dark[1] > dark[0] + 0.04
    assert house_maps(gap_house, tiles, {}, {}, seed=1)[keys[0]].jpeg == maps[keys[0]].jpeg
    assert house_maps(gap_house, tiles, {}, {}, seed=2)[keys[0]].jpeg != maps[keys[0]].jpeg


def test_a_regular_tile_repeats_so_that_its_joints_stay_whole(gap_house):
    floor = SurfaceKey("a", "floor")
    image = carpet(0)
    image[:4], image[:, :4] = 20, 20
    tile = Tile(image, 0.5, "made up", True, regular=True)
    spread = {}
    for name, made in (("whole", tile), ("cut", replace(tile, regular=False))):
        found = house_maps(gap_house, {floor: made}, {}, {}, seed=0)[floor]
        joint = (image_from_bytes(found.jpeg) < 60).mean(axis=0)[..., 0] > 0.9
        steps = np.diff(np.flatnonzero(np.diff(joint.astype(int)) == 1)) / found.px_per_m
        spread[name] = np.abs(steps - 0.5).max()
    assert spread["whole"] < 0.02 < spread["cut"]


class _Known:
    observed, substance, material = True, "carpet", ""

    def __init__(self, key):
        self.key = key


def test_a_material_runs_on_through_a_door(rug, gap_house):
    tiles = {key: tile_of(rug) for key in gap_house.surface_keys()}
    floors = [SurfaceKey("a", "floor"), SurfaceKey("b", "floor")]
    maps = house_maps(gap_house, tiles, dict.fromkeys(floors, "floor-1"), {}, seed=0)
    left, right = (maps[key] for key in floors)
    scale = left.px_per_m
    shift = [round((r - le) * scale) for r, le in zip(right.area.low, left.area.low, strict=True)]
    pictures = [image_from_bytes(m.jpeg).astype(int) for m in (left, right)]
    shared = pictures[0].shape[1] - shift[0]
    assert shared > 3
    apart = pictures[0][max(shift[1], 0) :, shift[0] :][:200] - pictures[1][:200, :shared]
    assert np.abs(apart).mean() < 6
