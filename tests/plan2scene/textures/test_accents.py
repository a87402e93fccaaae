"""Walls of another paint than their room's: found by the photos' colours, textured on their own."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from plan2scene.colour import median_colour, srgb_to_linear
from plan2scene.errors import InputError
from plan2scene.house import SurfaceKey
from plan2scene.images import image_from_bytes, png_bytes
from plan2scene.io import read_json, write_parquet
from plan2scene.mesh.assembly import build_parts
from plan2scene.mesh.texture_files import textured
from plan2scene.plans.scene_writer import house_to_scene, write_scene_json
from plan2scene.textures.accents import find_accents
from plan2scene.textures.house_textures import make_textures
from plan2scene.textures.inputs import HouseData, HouseFiles, TextureSettings, Visible

WHITE, BLUE, SHADE = (0.8, 0.8, 0.78), (0.2, 0.3, 0.6), (0.5, 0.5, 0.5)
SETTINGS = TextureSettings(seed=0, size_px=128)


def seen(photo, walls, srgb, weight=0.2, plane=0, room="a", **facts):
    shares = np.tile(srgb_to_linear(np.array(srgb)), (32, 1)).astype(np.float32).ravel()
    row = {"photo": photo, "room_id": room, "surface": "wall", "plane": plane, "own": True}
    return row | {"walls": walls, "weight": weight, "colours": shares} | facts


def accents(tmp_path, rows):
    write_parquet(tmp_path / "colours.parquet", pd.DataFrame(rows), {"colours": "photo"})
    return find_accents(tmp_path / "colours.parquet")


def two_photos(mine, others=WHITE, **facts):
    rows = []
    for photo in ("p1.jpg", "p2.jpg"):
        rows += [seen(photo, "w1", mine, 0.1, **facts), seen(photo, "w2", others, plane=1)]
    return rows


def test_a_wall_of_another_paint_in_two_photos_is_an_accent(tmp_path):
    (found,) = accents(tmp_path, two_photos(BLUE))
    assert found.keys == (SurfaceKey("a", "wall.w1"),)
    np.testing.assert_allclose(found.colour, BLUE, atol=0.01)
    assert found.planes == {"wall/p1_0", "wall/p2_0"}


@pytest.mark.parametrize(
    "rows",
    [
        two_photos(SHADE),  # light and shade on one paint
        two_photos(BLUE)[:2],  # one photo alone
        two_photos(BLUE, own=False),  # through a door
        [row | {"walls": ""} for row in two_photos(BLUE)],
        [row | {"weight": 0.01} for row in two_photos(BLUE)],
        [row | {"walls": f"../{row['walls']}"} for row in two_photos(BLUE)],
        # One photo of two: its light does it.
        [seen("p1.jpg", "w1", BLUE, 0.1), seen("p1.jpg", "w2", WHITE)]
        + [seen("p2.jpg", "w1", WHITE, 0.1), seen("p2.jpg", "w2", WHITE)],
        # Photos that contradict each other: their light does it.
        [seen("p1.jpg", "w1", (0.8, 0.6, 0.6), 0.1), seen("p1.jpg", "w2", (0.6, 0.6, 0.8))]
        + [seen("p2.jpg", "w1", (0.6, 0.6, 0.8), 0.1), seen("p2.jpg", "w2", (0.8, 0.6, 0.6))],
    ],
)
def test_light_and_little_evidence_make_no_accent(tmp_path, rows):
    assert accents(tmp_path, rows) == []


@pytest.fixture
def gap_house(gap_house):
    """The house with dots in its walls' ids, as plans may have them."""
    walls = tuple(replace(wall, id=f"{wall.id}.1.a") for wall in gap_house.walls)
    return replace(gap_house, walls=walls)


@pytest.fixture
def inputs(gap_house, tmp_path):
    """A house of which two photos show a blue wall of room a, with crops of all its walls."""
    wall = next(w.id for w in gap_house.walls if w.room_ids == ("a",))
    write_scene_json(gap_house, tmp_path / "scene.json")
    noise = np.random.default_rng(0).integers(-6, 7, (128, 128, 1))
    pixels = {
        name: np.clip(np.array(tone) * 255 + noise, 0, 255).astype(np.uint8)
        for name, tone in (("p1_0", BLUE), ("p2_1", WHITE), ("p1_1", WHITE))
    }
    crops = pd.DataFrame({"crop_id": [f"wall/{name}_crop0" for name in pixels]})
    crops = crops.assign(photo="p1.jpg", room_id="a", surface="wall", metres=0.5, sharpness=1.0)
    crops["medoid"] = [False, False, True]
    crops["png"] = [png_bytes(image) for image in pixels.values()]
    write_parquet(tmp_path / "crops.parquet", crops, {"house": "h"})
    rows = [
        {"room_id": k.room_id, "surface": k.surface, "observed": True, "metres": 0.5}
        | {"substance": "plaster", "source": "", "confidence": 1.0, "material": "wall-1"}
        | {"embedding": np.zeros(11), "naive_embedding": np.zeros(8), "colour": np.array(WHITE)}
        for k in gap_house.surface_keys()
    ]
    write_parquet(tmp_path / "propagated.parquet", pd.DataFrame(rows), {"house": "h"})
    shown = [row | {"walls": wall if row["walls"] == "w1" else "x"} for row in two_photos(BLUE)]
    write_parquet(tmp_path / "colours.parquet", pd.DataFrame(shown), {"colours": "photo"})
    files = (tmp_path / name for name in ("scene.json", "crops.parquet"))
    data = HouseData(HouseFiles(gap_house.id, *files, colours=tmp_path / "colours.parquet"))
    return data.at(Visible(tmp_path / "propagated.parquet"), {}, SETTINGS), wall


def test_an_accent_wall_has_its_own_texture_in_the_house(inputs, gap_house, tmp_path):
    made, wall = inputs
    own, usual = SurfaceKey("a", f"wall.{wall}"), SurfaceKey("a", "wall")
    make_textures("crop", made, tmp_path / "t", maps=True, walls="wall")
    listed = read_json(tmp_path / "t" / "textures.json")["surfaces"]
    assert set(listed) == {f"{k.room_id}/{k.surface}" for k in (*gap_house.surface_keys(), own)}
    assert listed["/".join(own)]["crops"] == ["wall/p1_0_crop0"]
    assert "material" not in listed["/".join(own)]
    house, textures = textured(tmp_path / "t", gap_house)
    for key, tone in ((own, BLUE), (usual, WHITE)):
        np.testing.assert_allclose(
            median_colour(image_from_bytes(textures[key].image)), tone, atol=0.03
        )
    faces = {part.name: part.surface for part in build_parts(house) if part.surface}
    assert faces[f"a/wall/{wall}"] == own
    assert {key for name, key in faces.items() if "/wall/" in name} >= {own, usual}
    plain = {key: (tile.png, tile.size_m) for key, tile in textures.items()}
    walls = {
        w["id"]: w
        for w in house_to_scene(house, plain)["scene"]["arch"]["elements"]
        if w["type"] == "Wall"
    }
    assert walls[wall]["materials"][0]["materialId"] == f"Material_{own.filename}"


def test_walls_of_a_room_share_a_texture_where_nothing_else_is_asked(inputs, gap_house, tmp_path):
    made, _wall = inputs
    make_textures("crop", made, tmp_path / "t")
    assert textured(tmp_path / "t", gap_house)[0] == gap_house
    data = HouseData(HouseFiles(gap_house.id, tmp_path / "scene.json", tmp_path / "crops.parquet"))
    blind = data.at(Visible(tmp_path / "propagated.parquet"), {}, SETTINGS)
    with pytest.raises(InputError, match=r"colours.parquet"):
        make_textures("crop", blind, tmp_path / "u", walls="wall")
