"""Normal maps: slopes towards dark joints, as steep as the substance, none where nothing shows."""

import io

import numpy as np
import pytest
from glb_file import chunks
from PIL import Image

from plan2scene.images import jpeg_bytes, png_bytes
from plan2scene.mesh.assembly import build_parts
from plan2scene.mesh.glb import write_glb
from plan2scene.mesh.relief import SETTINGS, normal_map, tangents
from plan2scene.mesh.texture_files import MapTexture, TileTexture


def joints(contrast=90, size_px=64, size_m=0.5):
    """Return a tile with a joint down its middle and one across, darker by `contrast`."""
    image = np.full((size_px, size_px, 3), 130)
    middle = slice(size_px // 2 - 2, size_px // 2 + 2)
    image[middle] = image[:, middle] = 130 - contrast
    image = image.astype(np.uint8)
    return TileTexture(png_bytes(image), size_m, True, "tile")


def slopes(data):
    """Return x and y of a normal map, (h, w) each in [-1, 1]."""
    values = np.asarray(Image.open(io.BytesIO(data)), np.float64) / 127.5 - 1
    np.testing.assert_allclose(np.linalg.norm(values, axis=2), 1, atol=0.1)
    return values[..., 0], values[..., 1]


@pytest.mark.parametrize("contrast", [90, -90])
def test_surfaces_fall_towards_joints_light_or_dark(contrast):
    x, y = slopes(normal_map(joints(contrast)))
    assert x[10, 28:31].min() > 0.05 and x[10, 33:36].max() < -0.05  # the joint is right, left
    assert y[28:31, 10].max() < -0.05 and y[33:36, 10].min() > 0.05  # below, above
    assert abs(x.mean()) < 0.01 and abs(y.mean()) < 0.01


def test_as_steep_as_the_substance_and_the_contrast_say():
    few, some, many = (np.hypot(*slopes(normal_map(joints(c)))) for c in (14, 26, 110))
    assert few.mean() < 0.7 * some.mean() < 0.7 * many.mean()
    assert np.sqrt((many**2).mean()) == pytest.approx(SETTINGS.slopes["tile"], rel=0.3)


@pytest.mark.parametrize("substance", ["tile", None])
def test_nothing_where_no_relief_shows(substance):
    plain = np.full((32, 32, 3), 150, np.uint8)
    plain[::2] += 1
    assert normal_map(TileTexture(png_bytes(plain), 1.0, True, substance)) is None
    if substance is None:
        tile = joints()
        assert normal_map(TileTexture(tile.png, tile.size_m)) is None


def test_a_map_has_no_relief_at_its_edges_from_the_other_side():
    image = np.full((64, 64, 3), 130, np.uint8)
    image[::8] = 60
    image[:, 40:] //= 2  # right and left differ: only a tile's edge is between them
    tile = TileTexture(png_bytes(image), 0.5, True, "plaster")
    whole = MapTexture(
        tile.png, 0.5, True, "plaster", jpeg=jpeg_bytes(image, quality=95), extent_m=(0.5, 0.5)
    )
    edges = [
        np.abs(slopes(normal_map(texture))[0][4:-4, [0, -1]]).max() for texture in (tile, whole)
    ]
    assert edges[1] < 0.3 * edges[0]


def test_files_have_them_on_demand_and_valid(gap_house, tmp_path):
    textures = dict.fromkeys(gap_house.surface_keys(), joints())
    write_glb(gap_house, textures, tmp_path / "plain.glb")
    write_glb(gap_house, textures, tmp_path / "relief.glb", relief=True)
    plain, made = (chunks(tmp_path / f"{name}.glb")[0] for name in ("plain", "relief"))
    assert not any("normalTexture" in material for material in plain["materials"])
    named = {m["name"]: m["normalTexture"] for m in made["materials"] if "normalTexture" in m}
    assert set(named) == {key.filename for key in textures}
    images = {made["textures"][use["index"]]["source"] for use in named.values()}
    assert len(images) == 1  # equal ones once
    assert made["images"][images.pop()]["mimeType"] == "image/jpeg"


def test_tangents_run_along_the_image_s_rows_and_up_it(gap_house, tmp_path):
    by_name = {part.name: part for part in build_parts(gap_house)}
    along = {"a/floor": (1, 0, 0), "a/ceiling": (1, 0, 0), "a/wall/a_w0": (1, 0, 0)}
    up = {"a/floor": (0, 0, -1), "a/ceiling": (0, 0, -1), "a/wall/a_w0": (0, 1, 0)}
    for name, expected in along.items():
        made = tangents(by_name[name])
        assert np.allclose(made[:, :3], expected, atol=1e-5)
        turned = np.cross(by_name[name].mesh.vertex_normals, made[:, :3]) * made[:, 3:]
        assert np.allclose(turned, up[name], atol=1e-5)
    textures = dict.fromkeys(gap_house.surface_keys(), joints())
    write_glb(gap_house, textures, tmp_path / "relief.glb", relief=True)
    tree = chunks(tmp_path / "relief.glb")[0]
    primitives = [mesh["primitives"][0] for mesh in tree["meshes"]]
    mapped = ["normalTexture" in tree["materials"][entry["material"]] for entry in primitives]
    assert ["TANGENT" in entry["attributes"] for entry in primitives] == mapped
    assert any(mapped) and not all(mapped)
