"""Large squares of which no crop shows a whole period are completed; nothing else is."""

from types import SimpleNamespace

import numpy as np
import pytest

from plan2scene.house import SurfaceKey
from plan2scene.images import png_bytes
from plan2scene.textures.crops import Crop
from plan2scene.textures.exemplar.house_tiles import exemplar_tiles
from plan2scene.textures.exemplar.make import ExemplarCrop, find_surface, make_exemplar
from plan2scene.textures.inputs import KnownSurface, TextureInputs, TextureSettings

SIDE_M, CROP_M = 0.4, 0.5


def crop(x_m, y_m, *, square_m=SIDE_M, dark=(150, 140, 120), light=(200, 195, 185)):
    """Return a crop of a checkerboard with joints, its corner at (x, y) metres."""
    rng = np.random.default_rng(round(1000 * (x_m + 7 * y_m)))
    metres = (np.arange(128) + 0.5) / 128 * CROP_M
    columns, rows = np.meshgrid((metres + x_m) / square_m, (metres + y_m) / square_m)
    odd = (np.floor(columns) + np.floor(rows)) % 2 == 1
    image = np.where(odd[..., None], dark, light) + rng.normal(0, 1.5, (128, 128, 1))
    at_joint = [np.abs(v - np.round(v)) * square_m < 0.008 for v in (columns, rows)]
    image[at_joint[0] | at_joint[1]] -= 25
    return ExemplarCrop(image.clip(0, 255).astype(np.uint8), CROP_M, 1.0)


def places(count=6):
    """Return corners of crops that show one joint each way."""
    rng = np.random.default_rng(0)
    return rng.uniform(0.12, 0.28, (count, 2))


def test_a_checkerboard_larger_than_its_crops_is_completed():
    crops = [crop(*place) for place in places()]
    made = make_exemplar(crops, size_px=128)
    assert made.pattern.completed in crops
    assert made.crops == (crops.index(made.pattern.completed),)
    # At least as large as what a crop shows from a joint to its border, at most what is true.
    cut = made.pattern.cut
    for side, cells in ((cut.wide, cut.columns), (cut.high, cut.rows)):
        assert cells >= 1
        assert 2 * 0.3 < made.pattern.size_m * side / cells < 2 * SIDE_M * 1.03
    grey = made.image.mean(axis=2)
    # Half dark and half light, as sharply apart as in the crops.
    dark, light = np.percentile(grey, (20, 80))
    assert light - dark == pytest.approx(193 - 137, abs=16)
    assert abs(np.median(grey) - grey.mean()) < 25


def test_small_squares_and_plain_surfaces_stay():
    checks = [crop(*place, square_m=0.12) for place in places()]
    plain = [crop(*place, square_m=50.0) for place in places() + 5]
    for crops in (checks, plain):
        assert find_surface(crops, size_px=128).completed is None


def test_completed_squares_go_on_tiled_surfaces_alone():
    """The bathroom's wall passes for plaster by its crops; no other wall of the house is seen."""
    bath = SurfaceKey("bath", "wall")
    crops = [
        Crop(f"wall/p_0_crop{k}", bath, png_bytes(crop(*place).image), CROP_M, 1.0)
        for k, place in enumerate(places())
    ]
    facts = {"size_m": 0.5, "source": "", "confidence": 1.0, "naive_embedding": None}
    kinds = {"bath": "plaster", "bed": "plaster", "shower": "tile"}
    surfaces = tuple(
        KnownSurface(
            SurfaceKey(room, "wall"),
            room == "bath",
            substance=substance,
            embedding=np.r_[np.full(8, k), [0.7, 0.65, 0.6]],
            **facts,
        )
        for k, (room, substance) in enumerate(kinds.items())
    )
    data = SimpleNamespace(exemplars={}, files=SimpleNamespace(house_id="h", patterns=None))
    settings = TextureSettings(seed=0, size_px=128)
    made = exemplar_tiles(TextureInputs(data, surfaces, tuple(crops), {}, settings))
    assert made[bath].pattern.completed is not None
    assert made[SurfaceKey("bed", "wall")].source.startswith("made up: ")
    assert made[SurfaceKey("shower", "wall")].source.startswith("exemplar of bath, ")
