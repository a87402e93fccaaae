import numpy as np
import pytest

from plan2scene.errors import InputError
from plan2scene.images import write_png
from plan2scene.materials import KINDS, load_texture_folder, random_material
from plan2scene_workshop.rendering.index import textures_of_split


def seam_ratio(image, axis):
    """Return the mean step across the wrap edge over the largest one inside (joints: about 1)."""
    grey = image.astype(float).mean(2)
    steps = np.abs(np.roll(grey, -1, axis) - grey).mean(1 - axis)
    return float(steps[-1] / max(steps[:-1].max(), 0.5))


@pytest.mark.parametrize(("substance", "kind"), [(s, k) for s in KINDS for k in KINDS[s]])
def test_every_kind_tiles_and_has_a_metric_size(substance, kind):
    for seed in range(3):
        material = random_material(substance, seed, kind=kind)
        assert material.albedo.shape == (256, 256, 3) and material.albedo.dtype == np.uint8
        assert (material.substance, material.kind) == (substance, kind)
        assert 0.1 <= material.size_m <= 3.0 and 0.0 < material.roughness <= 1.0
        assert seam_ratio(material.albedo, 0) <= 1.3 and seam_ratio(material.albedo, 1) <= 1.3


def test_a_seed_tells_the_material_and_a_given_colour_its_mean():
    first, again = random_material("wood", 5), random_material("wood", 5)
    assert first.name == again.name and np.array_equal(first.albedo, again.albedo)
    assert random_material("wood", 6).name != first.name
    paint = random_material("plaster", 3, kind="paint", colour_rgb=(200, 180, 160))
    assert np.allclose(paint.albedo.reshape(-1, 3).mean(0), (200, 180, 160), atol=3)


def test_texture_folder_reads_images_of_a_split(tmp_path):
    for k, substance in enumerate(("wood", "tile")):
        texture = random_material(substance, k, size_px=64)
        write_png(tmp_path / substance / f"{substance}1.png", texture.albedo)
    (tmp_path / "index.csv").write_text("id,split\nwood1,train\ntile1,val\n")
    textures = load_texture_folder(tmp_path)
    assert [m.substance for m in textures] == ["wood", "tile"]
    assert all(m.albedo.shape == (256, 256, 3) for m in textures)
    assert max(seam_ratio(m.albedo, 0) for m in textures) <= 1.3  # resized on the torus
    (only,) = textures_of_split(tmp_path, "val", size_px=64)
    assert only.name == "scan-tile1"
    assert np.array_equal(only.albedo, random_material("tile", 1, size_px=64).albedo)
    with pytest.raises(InputError, match="textures of split test, found none"):
        textures_of_split(tmp_path, "test")
