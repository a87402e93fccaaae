from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from painted_house import Painted, paint_of

from plan2scene.colour import median_colour, srgb_to_linear
from plan2scene.house import SurfaceKey
from plan2scene.images import image_from_bytes
from plan2scene.io import read_parquet, write_parquet
from plan2scene.mesh.assembly import assemble
from plan2scene.mesh.texture_files import textured
from plan2scene.paint.accents import find_accents
from plan2scene.paint.observations import PlaneColours, write_colours
from plan2scene.paint.surfaces import observations_of, read_paint
from plan2scene.plans.scene_writer import house_to_scene

WHITE, BLUE, SHADE = (0.8, 0.8, 0.78), (0.2, 0.3, 0.6), (0.5, 0.5, 0.5)
ORANGE, LAMPLIT = (0.85, 0.35, 0.15), (0.85, 0.72, 0.6)


def seen(photo, wall, srgb, weight=0.2, plane=0, own=True, surface="wall"):
    shares = np.tile(srgb_to_linear(np.array(srgb)), (32, 1)).astype(np.float32)
    walls = (wall,) if wall else ()
    return PlaneColours(photo, ("a",), surface, plane, own, walls, weight, shares)


def photos(mine, others=WHITE, count=2, weight=0.1, **facts):
    """Return what `count` photos show of wall w1 beside a larger w2."""
    return [
        plane
        for k in range(count)
        for plane in (
            seen(f"p{k}.jpg", "w1", mine, weight, **facts),
            seen(f"p{k}.jpg", "w2", others, plane=1, **facts),
        )
    ]


def accents(tmp_path, planes):
    write_colours(tmp_path / "colours.parquet", planes, dataset="d", house_id="h")
    return find_accents(read_parquet(tmp_path / "colours.parquet")[0])


@pytest.mark.parametrize(
    "planes",
    [
        photos(BLUE),
        photos(ORANGE, count=1),
        photos(ORANGE, count=1, weight=0.5),  # the most of what is seen is the accent
        # A third photo that was put into the wrong corner.
        photos(ORANGE, count=3) + photos(WHITE, ORANGE, count=4)[6:],
    ],
)
def test_a_wall_of_another_paint_is_an_accent(tmp_path, planes):
    assert accents(tmp_path, planes) == [("a", "w1")]


@pytest.mark.parametrize(
    "planes",
    [
        photos(SHADE),  # light and shade on one paint
        photos(LAMPLIT),  # lamp and daylight
        photos((0.5, 0.2, 0.1), (0.8, 0.55, 0.3), count=3),  # boards in shade
        photos(ORANGE, own=False),  # through a door
        [replace(plane, walls=()) for plane in photos(ORANGE)],
        photos(ORANGE, weight=0.005),
        # A cupboard that one mask takes for wall.
        photos(ORANGE, count=1) + photos(WHITE)[2:],
    ],
)
def test_light_and_little_evidence_make_no_accent(tmp_path, planes):
    assert accents(tmp_path, planes) == []


def test_a_strong_colour_that_is_all_that_is_seen_is_that_of_its_wall(tmp_path):
    only = [seen("p.jpg", "w1", ORANGE)]
    white = [replace(seen("q.jpg", "w9", WHITE), rooms=("b",))]
    orange = [replace(seen("q.jpg", "w9", ORANGE), rooms=("b",))]
    assert accents(tmp_path, only + white) == [("a", "w1")]
    assert accents(tmp_path, [seen("p.jpg", "w1", LAMPLIT), *white]) == []
    assert accents(tmp_path, [*only, seen("p.jpg", "w2", ORANGE, plane=1), *white]) == []
    assert accents(tmp_path, [*only, seen("r.jpg", "", ORANGE), *white]) == []
    assert accents(tmp_path, only + orange) == []  # as walls of this house are


def test_glare_does_not_wash_out_an_accent(tmp_path):
    planes = photos(ORANGE)
    shade, glare = np.linspace(0.3, 1.7, 32).clip(0, 1)[:, None], np.repeat([0.0, 0.3], 16)[:, None]
    shown = [
        replace(plane, colours=(shade * plane.colours + glare).astype(np.float32))
        if plane.walls == ("w1",)
        else plane
        for plane in planes
    ]
    write_colours(tmp_path / "colours.parquet", shown, dataset="d", house_id="h")
    found = {i.surface.surface: i.colour for i in observations_of(tmp_path / "colours.parquet")}
    red, green, blue = srgb_to_linear(np.array(ORANGE))
    assert found["wall.w1"][1] / found["wall.w1"][0] == pytest.approx(green / red, rel=0.01)
    assert found["wall.w1"][2] / found["wall.w1"][0] == pytest.approx(blue / red, rel=0.01)


def test_a_white_wall_is_the_accent_of_a_room_of_a_colour(tmp_path):
    assert accents(tmp_path, photos(WHITE, BLUE, weight=0.02)) == [("a", "w1")]


@pytest.mark.parametrize("asked", [True, False])
def test_an_accent_wall_has_its_own_paint_in_the_house(gap_house, tmp_path, asked):
    walls = tuple(replace(wall, id=f"{wall.id}.1.a") for wall in gap_house.walls)
    house = replace(gap_house, walls=walls)
    wall = next(w.id for w in house.walls if w.room_ids == ("a",))
    planes = [
        replace(plane, walls=(wall,)) if plane.walls == ("w1",) else plane
        for plane in photos(BLUE, weight=0.15)
    ]
    planes += [seen(f"p{k}.jpg", "", WHITE, surface="ceiling") for k in (0, 1)]
    file = paint_of(tmp_path, planes, accents=asked)
    table, metadata = read_parquet(file)
    odd = table[table["surface"] == "wall"].assign(surface="wall.a/../../x")  # no name of a file
    write_parquet(file, pd.concat([table, odd]), metadata)
    keys = ["/".join(key) for key in house.surface_keys()]
    out = Painted(file, tmp_path, dict.fromkeys(keys, np.full((32, 32, 3), 150, np.uint8)))
    assert not list(tmp_path.rglob("x.*"))
    shown, textures = textured(tmp_path / "out", house)
    own, usual = SurfaceKey("a", f"wall.{wall}"), SurfaceKey("a", "wall")
    paint, white = read_paint(file)
    assert (own in paint) is (own in textures) is asked and usual in white
    if not asked:
        assert shown.accents == ()
        return
    for key in (own, usual):
        found = srgb_to_linear(median_colour(image_from_bytes(textures[key].image)))
        assert found == pytest.approx(paint[key], abs=0.02)
    assert paint[own] == pytest.approx(srgb_to_linear(np.array(BLUE)) * 1.3, rel=0.3)
    assert out.surfaces["/".join(own)]["evidence"]["photos"] == ["p0.jpg", "p1.jpg"]
    faces = {part.name: part.surface for part in assemble(shown).parts if part.surface}
    assert faces[f"a/wall/{wall}"] == own
    assert {key for name, key in faces.items() if "/wall/" in name} >= {own, usual}
    plain = {key: (image.png, image.size_m) for key, image in textures.items()}
    elements = house_to_scene(shown, plain)["scene"]["arch"]["elements"]
    walls = {item["id"]: item for item in elements if item["type"] == "Wall"}
    assert walls[wall]["materials"][0]["materialId"] == f"Material_{own.filename}"
