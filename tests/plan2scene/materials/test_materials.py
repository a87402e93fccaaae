"""Procedural materials: they tile, have a real size, are varied and reproducible."""

from pathlib import Path

import numpy as np
import pytest

from plan2scene.errors import InputError
from plan2scene.house import SUBSTANCES
from plan2scene.images import write_png
from plan2scene.materials import KINDS, load_texture_folder, periodic_noise, random_material
from plan2scene.materials.bonds import basket, bond, diagonal_grid, herringbone, hexagons

EVERY_KIND = [(substance, kind) for substance in KINDS for kind in KINDS[substance]]


def seam_ratio(image: np.ndarray, axis: int) -> float:
    """Return the mean step across the wrap edge over the largest one inside (joints: about 1)."""
    grey = image.astype(float).mean(2)
    steps = np.abs(np.roll(grey, -1, axis) - grey).mean(1 - axis)
    return float(steps[-1] / max(steps[:-1].max(), 0.5))


@pytest.mark.parametrize(("substance", "kind"), EVERY_KIND)
def test_every_kind_tiles_and_has_a_metric_size(substance: str, kind: str) -> None:
    for seed in range(3):
        material = random_material(substance, seed, kind=kind)
        assert material.albedo.shape == (256, 256, 3)
        assert material.albedo.dtype == np.uint8
        assert (material.substance, material.kind) == (substance, kind)
        assert 0.1 <= material.size_m <= 3.0
        assert 0.0 < material.roughness <= 1.0
        assert seam_ratio(material.albedo, 0) <= 1.3
        assert seam_ratio(material.albedo, 1) <= 1.3


def test_seam_ratio_sees_a_texture_that_does_not_tile() -> None:
    cut = random_material("wood", 1, kind="plain").albedo[:200, :200]
    assert max(seam_ratio(cut, 0), seam_ratio(cut, 1)) > 1.5


def test_same_seed_same_bytes_and_other_seed_other_material() -> None:
    first, again = random_material("wood", 5), random_material("wood", 5)
    assert first.name == again.name
    assert np.array_equal(first.albedo, again.albedo)
    assert random_material("wood", 6).name != first.name


def test_a_given_colour_is_the_mean_colour_of_paint() -> None:
    paint = random_material("plaster", 3, kind="paint", colour_rgb=(200, 180, 160))
    assert np.allclose(paint.albedo.reshape(-1, 3).mean(0), (200, 180, 160), atol=3)


def test_colours_vary_and_ceilings_can_be_any_size() -> None:
    means = [random_material("carpet", s, size_px=64).albedo.mean() for s in range(30)]
    assert np.std(means) > 15
    assert random_material("tile", 0, size_px=64).albedo.shape == (64, 64, 3)


@pytest.mark.parametrize(
    "arguments", [("stone", None, 64), ("wood", "carpet", 64), ("wood", "planks", 8)]
)
def test_unknown_names_are_refused(arguments: tuple[str, str | None, int]) -> None:
    substance, kind, size = arguments
    with pytest.raises(ValueError, match="expected"):
        random_material(substance, 0, kind=kind, size_px=size)


def test_layouts_have_whole_units() -> None:
    """Each layout has the number of units that its arguments say, all of the same area."""
    cases = [
        (bond(240, 2, 8, 0.8, np.arange(8) * 0.5), 16),
        (diagonal_grid(240, 2, 0.8), 8),
        (herringbone(240, 4, 0.8, diagonal=False), 16),
        (herringbone(240, 4, 0.8, diagonal=True), 8),
        (basket(240, 4, 3, 0.8), 48),
        (hexagons(240, 7, 0.7), 56),
    ]
    for plan, count in cases:
        _, areas = np.unique(plan.key, return_counts=True)
        assert len(areas) == count
        assert areas.max() < 1.2 * areas.min()
        assert float(plan.edge.min()) > -plan.pixel


def test_noise_is_normalised_and_periodic() -> None:
    field = periodic_noise.spectral_noise(np.random.default_rng(0), 128, 2.0, low=2)
    assert abs(float(field.mean())) < 1e-3
    assert float(field.std()) == pytest.approx(1.0, abs=1e-3)
    shifted = periodic_noise.sample(
        field, *np.meshgrid(np.arange(128.0) + 128, np.arange(128.0) - 128)
    )
    assert np.allclose(shifted, field, atol=1e-5)


def test_texture_folder_reads_images_and_split(tmp_path: Path) -> None:
    for k, substance in enumerate(("wood", "tile")):
        texture = random_material(substance, k, size_px=64)
        write_png(tmp_path / substance / f"{substance}1.png", texture.albedo)
    (tmp_path / "index.csv").write_text("id,split\nwood1,train\ntile1,val\n")
    assert [m.substance for m in load_texture_folder(tmp_path)] == ["wood", "tile"]
    (only,) = load_texture_folder(tmp_path, "val", size_px=64)
    assert only.name == "scan-tile1"
    assert np.array_equal(only.albedo, random_material("tile", 1, size_px=64).albedo)
    with pytest.raises(InputError, match="none of split test"):
        load_texture_folder(tmp_path, "test")


@pytest.mark.shared
def test_real_textures_keep_their_seam_when_resized() -> None:
    folder = Path(__file__).parents[4] / "shared" / "textures" / "ambientcg128"
    if not folder.is_dir():
        pytest.skip("no shared textures")
    textures = load_texture_folder(folder, "val")
    assert {m.substance for m in textures} == set(SUBSTANCES)
    assert all(m.albedo.shape == (256, 256, 3) for m in textures)
    assert np.median([seam_ratio(m.albedo, 0) for m in textures]) < 1.0
