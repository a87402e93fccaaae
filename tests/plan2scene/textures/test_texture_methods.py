import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from sample_houses import rooms_in_a_row
from small_models import write_texture_models

from plan2scene.colour import median_colour
from plan2scene.errors import InputError
from plan2scene.house import House, SurfaceKey
from plan2scene.images import image_from_bytes, png_bytes, read_image
from plan2scene.io import write_parquet
from plan2scene.mesh.assembly import assemble
from plan2scene.mesh.texture_files import load_textures
from plan2scene.plans.scene_writer import write_scene_json
from plan2scene.textures.crops import Crop, choose_crop, read_pool, surface_extent, write_pool
from plan2scene.textures.decoding import even_crop
from plan2scene.textures.house_textures import make_textures
from plan2scene.textures.inputs import HouseData, HouseFiles, TextureSettings, Visible
from plan2scene.textures.library import read_library, write_library
from plan2scene.textures.methods import texture_methods
from plan2scene.textures.seams import wrap_ratio

SIZE = 128
#: Methods that have a tile of the size asked for.
DECODED = ("naivesynth", "synth", "synth-large", "exemplar")


PLAN = House(
    "h1", rooms_in_a_row(bed1="Bedroom", bed2="Bedroom", hall="Corridor", bath="Bathroom"), ()
)


def _image(level, seed=0):
    noise = np.random.default_rng(seed).integers(-6, 7, (SIZE, SIZE, 1))
    ramp = np.linspace(-40, 40, SIZE)[None, :, None]
    return np.clip(level + noise + ramp + np.zeros((1, 1, 3)), 0, 255).astype(np.uint8)


def _crop(name, room, surface, level, seed=0):
    return Crop(name, SurfaceKey(room, surface), png_bytes(_image(level, seed)), 0.5)


CROPS = [_crop(name, "bed1", "floor", k) for name, k in zip("abc", (60, 100, 130), strict=True)]
CROPS += [_crop("d", "hall", "floor", 200), _crop("e", "hall", "wall", 220)]
#: What is foretold of every surface.
TOLD = dict(substance="wood", metres=0.8, source="propagation", confidence=1.0, material="")


def test_the_medoid_then_rooms_of_the_type_then_the_same_surface_then_anything():
    choice = choose_crop(PLAN, SurfaceKey("bed1", "floor"), CROPS, 0)
    assert choice.crop.crop_id == "b" and choice.source == "b"
    for seed in range(8):
        choice = choose_crop(PLAN, SurfaceKey("bed2", "floor"), CROPS, seed)
        assert choice.crop.key.room_id == "bed1"
    drawn = {
        choose_crop(PLAN, SurfaceKey("bed2", "floor"), CROPS, s).crop.crop_id for s in range(30)
    }
    assert drawn == {"a", "b", "c"}
    wall = choose_crop(PLAN, SurfaceKey("bath", "wall"), CROPS, 0)
    assert wall.crop.crop_id == "e" and "another wall" in wall.source
    assert "another surface" in choose_crop(PLAN, SurfaceKey("bath", "ceiling"), CROPS, 0).source
    assert choose_crop(PLAN, SurfaceKey("bath", "wall"), [], 0) is None


def test_crops_of_other_houses_come_after_rooms_of_the_type_and_before_the_rest(files):
    crops = pd.read_parquet(files / "crops.parquet")
    write_parquet(files / "other.parquet", crops.assign(medoid=[1, 0, 0, 1, 1]), {"house": "o"})
    given = [files / "scene.json"], [files / "other.parquet"], ["o"]
    write_pool(*given, files / "pool.parquet", dataset="d")
    pool = read_pool(files / "pool.parquet", but="h1")
    assert [(p.house, p.crop.crop_id, p.types) for p in pool] == [
        ("o", "a", ("Bedroom",)),
        ("o", "d", ("Corridor",)),
        ("o", "e", ("Corridor",)),
    ]
    assert read_pool(files / "pool.parquet", but="o") == []
    of_bath = [replace(p, types=("Bathroom",)) for p in pool if p.crop.crop_id == "d"]
    key = SurfaceKey("bath", "floor")
    wanted = choose_crop(PLAN, key, CROPS[:3], 0, others=of_bath)
    assert wanted.source == "such a room of another house: d of hall"
    assert "another floor of the house" in choose_crop(PLAN, key, CROPS[:3], 0, others=pool).source
    wall = choose_crop(PLAN, SurfaceKey("bath", "wall"), CROPS[:3], 0, others=pool)
    assert wall.source == "a wall of another house: e of hall"
    own = choose_crop(PLAN, SurfaceKey("bed2", "floor"), CROPS, 0, others=pool)
    assert "a room of its type" in own.source
    folder, surfaces = _make(
        files, "crop", hidden=["p1.jpg", "p2.jpg"], crop_pool=files / "pool.parquet"
    )
    assert surfaces["bed1/floor"]["source"] == "such a room of another house: a of bed1"
    assert np.array_equal(read_image(folder / "bed1_floor.png"), _image(60))


@pytest.fixture
def files(job_files, tmp_path):
    return Path(shutil.copytree(job_files, tmp_path / "job"))


@pytest.fixture(scope="module")
def job_files(tmp_path_factory):
    tmp_path = tmp_path_factory.mktemp("job")
    write_scene_json(PLAN, tmp_path / "scene.json")
    rows = [(c.crop_id, *c.key, c.png) for c in CROPS]
    crops = pd.DataFrame(rows, columns=["crop_id", "room_id", "surface", "png"])
    crops["photo"] = ["p1.jpg"] * 3 + ["p2.jpg"] * 2
    crops["metres"] = [0.5, 0.5, float("nan"), 0.5, 0.5]
    crops["sharpness"] = [1.0, 1.0, float("nan"), 1.0, 0.1]
    write_parquet(tmp_path / "crops.parquet", crops, {"house": "h1"})
    observed = {("bed1", "floor"), ("hall", "floor"), ("hall", "wall")}
    rng = np.random.default_rng(0)
    rows = [
        {
            "room_id": key.room_id,
            "surface": key.surface,
            "observed": tuple(key) in observed,
            "embedding": np.r_[rng.normal(size=8), rng.uniform(size=3)].astype(np.float32),
            "naive_embedding": rng.normal(size=8).astype(np.float32),
            **TOLD,
        }
        for key in PLAN.surface_keys()
    ]
    write_parquet(tmp_path / "propagated.parquet", pd.DataFrame(rows), {"house": "h1"})
    write_library(tmp_path / "library.parquet", folder=None, per_substance=2, seed=0, size_px=128)
    write_texture_models(*(tmp_path / f"{name}.safetensors" for name in ("synth", "naivesynth")))
    return tmp_path


def _inputs(files, *, size_px=64, seam_correction=None, hidden=(), crop_pool=None, threads=1):
    inputs = [files / f"{name}.parquet" for name in ("crops", "library", "patterns")]
    crops, library, patterns = (path if path.is_file() else None for path in inputs)
    house = HouseFiles("h1", files / "scene.json", crops, library, crop_pool, patterns=patterns)
    models = dict(texture=files / "synth.safetensors", naivesynth=files / "naivesynth.safetensors")
    corrected = {} if seam_correction is None else dict.fromkeys(texture_methods(), seam_correction)
    settings = TextureSettings(0, size_px, corrected, threads)
    return HouseData(house).at(Visible(files / "propagated.parquet", hidden), models, settings)


def _make(files, method, out="out", **changes):
    make_textures(method, _inputs(files, **changes), files / out)
    listing = json.loads((files / out / "textures.json").read_text())
    assert listing["method"] == method
    return files / out, listing["surfaces"]


def _told(files, tones=None, *, plain=False, **columns):
    """Rewrite colours (grey or RGB) and columns by names of surfaces; "" is the rest.

    All codes are nearly the same if they are `plain`.
    """
    table = pd.read_parquet(files / "propagated.parquet")
    names = table["room_id"] + "/" + table["surface"]
    for column, told in columns.items():
        old = zip(names, table.get(column, names), strict=True)
        table[column] = [told.get(name, told.get("", value)) for name, value in old]
    codes = []
    for k, (name, code) in enumerate(zip(names, table["embedding"], strict=True)):
        tone = (tones or {}).get(name, (tones or {}).get("", code[8:]))
        start = np.full(8, 1e-4 * k) if plain else code[:8]
        codes.append(np.r_[start, np.broadcast_to(tone, 3)].astype(np.float32))
    table["embedding"] = codes
    write_parquet(files / "propagated.parquet", table, {"house": "h1"})


def _without_joints(files, rooms, confidence):
    rows = {"room_id": rooms, "surface": "floor", "kind": "plain", "confidence": confidence}
    write_parquet(files / "patterns.parquet", pd.DataFrame(rows), {"house": "h1"})


@pytest.mark.parametrize("method", sorted(texture_methods()))
def test_every_surface_gets_a_tile_the_same_again(files, method):
    folder, surfaces = _make(files, method, size_px=48)
    assert set(surfaces) == {f"{k.room_id}/{k.surface}" for k in PLAN.surface_keys()}
    again, _ = _make(files, method, out="again", size_px=48, threads=2)
    side = 48 if method in DECODED else SIZE
    for key in PLAN.surface_keys():
        path = folder / f"{key.filename}.png"
        assert read_image(path).shape == (side, side, 3)
        assert path.read_bytes() == (again / path.name).read_bytes()
        assert surfaces[f"{key.room_id}/{key.surface}"]["size_m"] > 0
    assert surfaces["bed1/floor"]["observed"]
    assert not surfaces["bath/wall"]["observed"]


def test_crop_writes_the_crop_itself_with_its_scale_or_the_surface_s(files):
    folder, surfaces = _make(files, "crop")
    assert np.array_equal(read_image(folder / "bed1_floor.png"), _image(100))
    assert not surfaces["bed1/floor"]["seam_corrected"]
    corrected, entries = _make(files, "crop", out="corrected", seam_correction=True)
    assert entries["bed1/floor"]["seam_corrected"]
    before, after = (wrap_ratio(read_image(f / "bed1_floor.png")) for f in (folder, corrected))
    assert after < 1.3 < before
    crops = pd.read_parquet(files / "crops.parquet").assign(metres=float("nan"))
    write_parquet(files / "crops.parquet", crops, {"house": "h1"})
    assert _make(files, "crop")[1]["bed1/floor"]["size_m"] == 0.8


def test_retrieve_takes_library_tiles_with_their_size(files):
    folder, surfaces = _make(files, "retrieve")
    library = read_library(files / "library.parquet")
    index = library.nearest(_image(100))
    assert np.array_equal(read_image(folder / "bed1_floor.png"), library.tiles[index])
    assert surfaces["bed1/floor"]["size_m"] == pytest.approx(library.size_m[index])
    assert library.names[index] in surfaces["bed1/floor"]["source"]


def test_medoid_colour_is_the_median_of_the_medoid_everywhere(files):
    folder, surfaces = _make(files, "medoid_colour", seam_correction=True)
    tile = read_image(folder / "bed1_floor.png")
    assert (tile == np.sort(_image(100).reshape(-1, 3), axis=0)[(SIZE * SIZE - 1) // 2]).all()
    assert surfaces["bed1/floor"]["source"] == "median colour of b"
    assert not surfaces["bed1/floor"]["seam_corrected"]
    assert any(room in surfaces["bath/floor"]["source"] for room in ("of hall", "bed1"))


def test_projection_stretches_the_largest_sharp_crop_once_over_the_surface(files):
    crops = pd.read_parquet(files / "crops.parquet")
    crops["metres"] = [0.499, 0.501, float("nan"), 0.5, 0.5]
    crops["sharpness"] = [1.5, 1.0, 9.0, 1.0, 0.1]
    write_parquet(files / "crops.parquet", crops, {"house": "h1"})
    folder, surfaces = _make(files, "projection")
    assert np.array_equal(read_image(folder / "bed1_floor.png"), _image(60))
    assert surfaces["bed1/floor"]["source"] == "a, stretched"
    textures = load_textures(folder, PLAN)
    for part in assemble(PLAN).parts:
        if part.surface is not None:
            turns = textures[part.surface].turns(part.uv)
            assert turns.min() >= -1e-6 and turns.max() <= 1 + 1e-6, part.name
    assert surfaces["hall/floor"]["origin_m"] == [6.0, 0.0]
    assert surface_extent(PLAN, SurfaceKey("hall", "wall")) == (12.0, (0.0, 0.0))


def test_crops_of_hidden_photos_are_not_seen_and_without_any_the_library_is_used(files):
    folder, surfaces = _make(files, "crop", hidden=["p1.jpg"])
    assert "of hall" in surfaces["bed1/floor"]["source"]
    assert np.array_equal(read_image(folder / "bed1_floor.png"), _image(200))
    _, surfaces = _make(files, "crop", hidden=["p1.jpg", "p2.jpg"])
    assert "no crop in the house" in surfaces["bath/floor"]["source"]
    assert surfaces["bath/floor"]["source"].startswith("tile-")
    assert surfaces["bed1/wall"]["source"].startswith("plaster-")


def test_synth_large_has_the_statistics_of_the_selected_crop(files):
    crops = pd.read_parquet(files / "crops.parquet")
    mine = crops[(crops["room_id"] == "bed1") & (crops["surface"] == "floor")]
    own = mine.iloc[0]
    tone = np.median(image_from_bytes(own["png"]).reshape(-1, 3), axis=0) / 255
    _told(files, {"": tone}, source={"bed1/floor": own["crop_id"]})
    plain, _ = _make(files, "synth", out="plain", size_px=SIZE)
    large, surfaces = _make(files, "synth-large", out="large", size_px=SIZE)
    before, after = (read_image(f / "bed1_floor.png") for f in (plain, large))
    others = [image_from_bytes(png) for png in mine["png"][1:]]
    even = even_crop(image_from_bytes(own["png"]), others, tone, SIZE)
    assert abs(after.std() - even.std()) < 0.5 < abs(before.std() - even.std())
    assert surfaces["bed1/floor"]["source"] == f"{own['crop_id']}, its statistics"
    same = "bath_wall.png"  # no crop: as decoded
    assert (plain / same).read_bytes() == (large / same).read_bytes()


def test_exemplars_are_of_the_surface_s_crops_and_say_so(files):
    _told(files, {"bed1/floor": 100 / 255})  # that the selection gives it, of its crops
    folder, surfaces = _make(files, "exemplar", seam_correction=True)
    assert surfaces["bed1/floor"]["source"] == "exemplar of 3 crops"
    assert surfaces["bed1/floor"]["size_m"] == pytest.approx(0.5)
    assert np.median(read_image(folder / "bed1_floor.png")) == pytest.approx(100, abs=10)
    assert wrap_ratio(read_image(folder / "bed1_floor.png")) < 1.5 < wrap_ratio(_image(100))
    assert surfaces["hall/wall"]["source"].startswith("decoded from propagation: none of 1 crops")
    made_up = "made up: no exemplar of a wall of wood in the house"
    assert surfaces["bath/wall"]["source"] == made_up  # no exemplar of a wall is good
    assert not any(entry["seam_corrected"] for entry in surfaces.values())


@pytest.mark.parametrize("one_colour", [False, True])
def test_surfaces_of_one_material_share_their_pattern(files, one_colour):
    tones = (
        {"bed1/floor": 0.5, "hall/floor": 0.5}
        if one_colour
        else {"bed1/floor": 0.4, "hall/floor": 0.75}
    )
    _told(files, tones, material=dict.fromkeys(tones, "floor-1"))
    folder, surfaces = _make(files, "exemplar")
    bed, hall = (read_image(folder / f"{room}_floor.png") for room in ("bed1", "hall"))
    assert surfaces["bed1/floor"]["material"] == surfaces["hall/floor"]["material"] == "floor-1"
    assert "material" not in surfaces["bath/floor"]
    assert np.corrcoef(bed.ravel(), hall.ravel())[0, 1] > 0.9
    assert np.array_equal(bed, hall) == one_colour
    if one_colour:
        assert np.median(bed) == pytest.approx(127.5, abs=1.5)
    else:  # each in the colour of its own crops, 100 and 200
        assert np.median(hall) - np.median(bed) > 60


def test_unobserved_surfaces_take_the_nearest_exemplar_of_the_house(files):
    tone = np.array([0.75, 0.8, 0.8])  # not far from the hall's 200
    tones = {"bed2/floor": tone, "hall/floor": tone, "bath/floor": (0.2, 0.3, 0.6)}
    _told(files, tones, plain=True)
    folder, surfaces = _make(files, "exemplar")
    assert surfaces["bed2/floor"]["source"].startswith("exemplar of hall, ")
    assert np.abs(median_colour(read_image(folder / "bed2_floor.png")) - tone).max() < 0.01
    assert surfaces["bed2/floor"]["size_m"] == surfaces["hall/floor"]["size_m"]
    # Blue tiles are not of the material of grey ones, but blue paint is the grain of white paint.
    assert surfaces["bath/floor"]["source"].startswith("made up: ")
    image = read_image(folder / "bath_floor.png")
    assert median_colour(image) == pytest.approx([0.2, 0.3, 0.6], abs=0.02)
    _told(files, substance=dict.fromkeys((*tones, "bed1/floor"), "plaster"))
    _, surfaces = _make(files, "exemplar", out="plaster")
    assert surfaces["bath/floor"]["source"].startswith("exemplar of ")


@pytest.mark.parametrize("level", [200, 20])
def test_crops_of_another_thing_make_no_exemplar_of_a_surface(files, level):
    """All pixels say how bright the hall's floor is; its crop, of 200, is of it or is not."""
    greys = {"bed1/floor": 100, "hall/floor": level, "": 128}
    _told(files, colour={name: np.full(3, grey / 255) for name, grey in greys.items()})
    folder, surfaces = _make(files, "exemplar")
    own = "exemplar of 1 crops" if level == 200 else "exemplar of bed1, "
    assert surfaces["hall/floor"]["source"].startswith(own)
    assert np.median(read_image(folder / "hall_floor.png")) == pytest.approx(level, abs=3)


def test_an_exemplar_of_the_predicted_substance_goes_before_a_nearer_one(files):
    tones = {"bed1/floor": 0.4, "hall/floor": 0.55, "": 0.56}
    _told(files, tones, plain=True, substance={"hall/floor": "tile", "": "wood"})
    _, surfaces = _make(files, "exemplar")
    assert surfaces["bed2/floor"]["source"].startswith("exemplar of bed1, ")
    tiles = dict.fromkeys(("bed1/floor", "bath/floor"), "tile")
    _told(files, substance=tiles | {"bed2/floor": "carpet"})  # no exemplar has it
    folder, surfaces = _make(files, "exemplar")
    made_up = "made up: no exemplar of a floor of carpet in the house"
    assert surfaces["bed2/floor"]["source"] == made_up
    image = read_image(folder / "bed2_floor.png")
    assert median_colour(image) == pytest.approx(0.56, abs=0.01)
    assert wrap_ratio(image) < 1.5
    # One that the prediction copies needs no substance.
    table = pd.read_parquet(files / "propagated.parquet").set_index(["room_id", "surface"])
    _told(files, embedding={"bed2/floor": table.loc[("hall", "floor"), "embedding"]})
    assert _make(files, "exemplar")[1]["bed2/floor"]["source"].startswith("exemplar of hall, ")


def test_floors_without_joints_make_no_other_floor_tiled(files):
    _told(files, substance={"": "tile"})
    for confidence, source in ((0.4, "exemplar of "), (0.9, "made up: ")):
        _without_joints(files, ["hall", "bed1"], confidence)
        _, surfaces = _make(files, "exemplar")
        assert surfaces["bed2/floor"]["source"].startswith(source)
        assert surfaces["hall/floor"]["source"].startswith("exemplar of 1 crops")


@pytest.mark.parametrize(("confidence", "like"), [(0.4, "bed1"), (0.9, "hall")])
def test_a_floor_without_joints_is_like_another_without(files, confidence, like):
    tones = {"bed1/floor": 0.5, "hall/floor": 0.4, "bed2/floor": 0.52, "": 0.56}
    _told(files, tones, plain=True, substance={"hall/floor": "carpet", "": "wood"})
    _without_joints(files, ["hall", "bed2"], confidence)
    _, surfaces = _make(files, "exemplar")
    assert surfaces["bed2/floor"]["source"].startswith(f"exemplar of {like}, ")


def test_wrong_requests_are_refused(files):
    inputs = _inputs(files)
    with pytest.raises(InputError, match="texture model for method exemplar"):
        make_textures("exemplar", replace(inputs, models={}), files / "x")
    other = {"texture": files / "naivesynth.safetensors"}
    with pytest.raises(InputError, match="embedding of length 8"):
        make_textures("synth", replace(inputs, models=other), files / "x")
    without = HouseFiles("h1", inputs.data.files.scene, inputs.data.files.crops)
    with pytest.raises(InputError, match="a texture library"):
        make_textures("retrieve", replace(inputs, data=HouseData(without)), files / "x")
