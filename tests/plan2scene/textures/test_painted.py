import numpy as np
import pandas as pd
import pytest
from painted_house import Painted, paint_of

from plan2scene.colour import RENDER, as_uint8, linear_to_srgb, median_colour, srgb_to_linear
from plan2scene.house import SurfaceKey
from plan2scene.images import read_image
from plan2scene.io import read_json, write_parquet
from plan2scene.paint.observations import PlaneColours
from plan2scene.paint.surfaces import door_paints, paint_gains, plain_whites, read_paint
from plan2scene.textures.painted import COLOURED, OUTDOORS, evidence_of, plain


def plane(photo, room_id, surface, colour):
    shares = np.tile(np.float32(colour), (32, 1))
    return PlaneColours(photo, (room_id,), surface, 0, True, (), 0.05, shares)


@pytest.fixture
def paint(tmp_path):
    light = np.array([0.35, 0.33, 0.3])
    planes = [
        plane("1.jpg", "a", "floor", (0.1, 0.06, 0.04)),
        plane("1.jpg", "a", "wall", 0.82 * light),
        plane("1.jpg", "a", "ceiling", 0.8 * light),
        plane("1.jpg", "d", "wall", 0.81 * light),
        plane("2.jpg", "b", "wall", np.array([0.15, 0.3, 0.6]) * light),
        plane("2.jpg", "b", "ceiling", 0.82 * light),
        plane("2.jpg", "b", "frame", np.array([0.3, 0.14, 0.05]) * light),
    ]
    return paint_of(tmp_path, planes)


def test_a_strong_colour_stays_in_its_room_unless_most_rooms_have_it():
    red, wood = np.array([0.5, 0.05, 0.05]), np.array([0.5, 0.25, 0.1])
    unseen = {SurfaceKey("z", "wall"), SurfaceKey("z", "floor")}
    white = {SurfaceKey("z", "wall")}
    one = {SurfaceKey("a", "wall"): red}
    assert plain_whites(one, frozenset(), unseen) == white
    differ = one | {SurfaceKey("b", "wall"): red[::-1], SurfaceKey("c", "wall"): wood}
    assert plain_whites(differ, frozenset(), unseen) == white
    panelled = {SurfaceKey(name, "wall"): wood * (0.8 + 0.1 * k) for k, name in enumerate("bcd")}
    assert plain_whites(one | panelled, frozenset(), unseen) == set()
    balconies = {SurfaceKey(name, "wall"): np.full(3, 0.8) for name in "efgh"}
    assert plain_whites(panelled | balconies, frozenset(balconies), unseen) == white
    assert plain_whites(panelled | balconies, frozenset(balconies), unseen, "efgh") == set()


@pytest.mark.parametrize("rooms", ["ab", "abc"])
def test_walls_of_wood_in_three_rooms_are_one_panelling(tmp_path, rooms):
    woods = {"a": (0.6, 0.25, 0.08), "b": (0.2, 0.05, 0.02), "c": (0.5, 0.2, 0.05)}
    planes = [plane("4.jpg", "d", "wall", (0.15, 0.3, 0.6))]
    for room in rooms:
        planes.append(plane(f"{room}.jpg", room, "wall", woods[room]))
        planes.append(plane(f"{room}.jpg", room, "ceiling", (0.7, 0.7, 0.7)))
    file = paint_of(tmp_path, planes)
    found = [read_paint(file)[0][SurfaceKey(room, "wall")].tolist() for room in [*rooms, "d"]]
    assert len({tuple(paint) for paint in found}) == (2 if rooms == "abc" else 3)

    boards = {f"{room}/wall": np.full((64, 64, 3), (150, 90, 50), np.uint8) for room in "abcde"}
    boards["b/wall"][::16] = (75, 45, 25)
    unseen = {"observed": False, "source": "exemplar of a, 1.0 dE2000 to the predicted colour"}
    out = Painted(file, tmp_path, boards, {"b/wall": {"size_m": 2.0}, "e/wall": unseen})
    panelled = out.tile("b/wall")
    same = [room for room in "acde" if np.array_equal(out.tile(f"{room}/wall"), panelled)]
    assert same == (["a", "c", "e"] if rooms == "abc" else [])
    for room in same:
        entry = out.surfaces[f"{room}/wall"]
        assert entry["size_m"] == 2.0 and f"{room}/wall" not in out.maps
        assert entry["observed"] is (room != "e")


def test_tiles_and_maps_get_the_paint_and_keep_their_pattern(paint, tmp_path):
    tile = np.random.default_rng(0).integers(110, 140, (64, 64, 3), dtype=np.uint8)
    out, given = Painted(paint, tmp_path, {"b/wall": tile}), tmp_path / "t"
    painted = out.tile("b/wall")
    linear = srgb_to_linear(median_colour(painted))
    assert linear == pytest.approx(read_paint(paint)[0][SurfaceKey("b", "wall")], abs=0.02)
    assert np.corrcoef(tile[..., 1].ravel(), painted[..., 1].ravel())[0, 1] > 0.95
    assert painted.max() < 255
    whole = read_image(out.folder / "b_wall.jpg")
    assert median_colour(whole) == pytest.approx(median_colour(painted), abs=0.02)
    assert read_json(out.folder / "maps.json") == read_json(given / "maps.json")
    trim = read_json(out.folder / "trim.json")
    red, green, blue = trim[""]
    assert red > green > blue
    assert read_json(out.folder / "doors.json") == trim  # no photo shows a door
    evidence = out.surfaces["b/wall"].pop("evidence")
    assert evidence["photos"] == ["2.jpg"] and evidence["expected_error"] == COLOURED
    assert out.surfaces == read_json(given / "textures.json")["surfaces"]
    assert np.array_equal(read_image(given / "b_wall.png"), tile)


def test_white_paint_is_one_colour_and_takes_no_pattern_of_another_room(paint, tmp_path):
    grain = np.random.default_rng(0).normal(0.0, 1.2, (64, 64, 1))
    across = np.sin(np.arange(64) / 64 * 2 * np.pi)[None, :, None]
    stained = np.uint8(np.clip(130 + grain + across * np.array([12.0, 8.0, -8.0]), 0, 255))
    chequered = np.uint8(np.tile(np.kron([[60, 170], [170, 60]], np.ones((8, 8))), (4, 4)))
    tiles = {"a/wall": stained, "c/wall": np.dstack([chequered] * 3)}
    out = Painted(paint, tmp_path, tiles, {"c/wall": {"observed": False, "size_m": 0.5}})
    white = out.tile("a/wall").astype(int)
    assert np.ptp(white.mean(axis=0), axis=0).max() < 6  # 24 before
    assert np.corrcoef(grain[..., 0].ravel(), white[..., 1].ravel())[0, 1] > 0.8
    assert np.array_equal(out.tile("c/wall"), white)
    assert out.maps == {} and out.surfaces["c/wall"]["size_m"] == 1.0


def test_blinds_and_pictures_on_a_white_wall_are_no_pattern_of_it(paint, tmp_path):
    rng = np.random.default_rng(0)
    calm, tiles = (130 + rng.normal(0.0, 1.2, (64, 64, 3)) for _ in range(2))
    blinds = np.kron(rng.choice([60.0, 200.0], (8, 1, 1)), np.ones((8, 64, 3)))
    tiles[::16] = 115.0
    names = {"a/wall": blinds, "d/wall": calm, "a/ceiling": tiles}
    images = {name: np.uint8(image) for name, image in names.items()}
    out = Painted(paint, tmp_path, images, {"a/wall": {"substance": "tile"}})
    assert np.array_equal(out.tile("a/wall"), out.tile("d/wall"))
    painted = out.tile("a/ceiling").astype(int)
    assert painted[::16].mean() < painted.mean() - 10  # fainter joints stay


@pytest.mark.parametrize("folds", [True, False])
def test_the_folds_of_a_curtain_are_no_pattern_of_a_white_wall(paint, tmp_path, folds):
    wave = np.sin(2 * np.pi * np.arange(64) / 16)
    x, y = wave[None, :, None], wave[:, None, None]
    striped = 150 * np.exp(0.05 * (x if folds else (x + y) / 2**0.5)) * np.ones((64, 64, 3))
    out = Painted(paint, tmp_path, {"a/wall": striped.astype(np.uint8)})
    assert bool(out.tile("a/wall").std() < 2) is folds
    assert (out.folder / "a_wall.jpg").is_file() is not folds


def test_what_nothing_in_the_house_tells_of_is_plain(paint, tmp_path):
    """Neither boards of a panelled room in white, nor a pink floor that was predicted."""
    boards = np.full((64, 64, 3), 170, np.uint8)
    boards[::16] = 90
    pink, guessed = np.full_like(boards, (200, 150, 160)), {"observed": False, "substance": "tile"}
    names = {"c/wall": boards, "c/floor": pink, "d/floor": pink, "e/floor": pink}
    entries = {
        "c/wall": {"observed": False},
        "c/floor": guessed | {"source": "made up: no exemplar of a floor of tile in the house"},
        "d/floor": guessed | {"source": "exemplar of c, 3.0 dE2000 to the predicted colour"},
        "e/floor": guessed | {"substance": "wood"},
    }
    wall, floor, copied, wood = map(Painted(paint, tmp_path, names, entries).tile, names)
    assert wall.std() == 0 and wall.min() > 225
    red, green, blue = median_colour(floor)
    assert red > green > blue > red - 0.08
    assert all(median_colour(other)[2] > median_colour(other)[1] for other in (copied, wood))


def test_an_unseen_bathroom_is_like_another_one(paint, tmp_path):
    tiled = np.full((64, 64, 3), 170, np.uint8)
    tiled[::16] = 90
    boards = np.full((64, 64, 3), (180, 120, 60), np.uint8)
    names = {"a/wall": tiled, "b/wall": boards, "c/wall": boards, "e/wall": boards}
    other = {"observed": False, "source": "exemplar of b, 3.0 dE2000 to the predicted colour"}
    entries = {"a/wall": {"substance": "tile"}, "c/wall": other, "e/wall": other}
    out = Painted(paint, tmp_path, names, entries, bathrooms=["a", "c"])
    bath, unseen, room = (out.tile(f"{name}/wall") for name in "ace")
    assert np.array_equal(unseen, bath) and not np.array_equal(room, bath)
    entry = out.surfaces["c/wall"]
    assert entry["substance"] == "tile" and entry["observed"] is False
    assert entry["evidence"]["like"] == "a"
    assert entry["evidence"]["words"].startswith("guessed from the a")
    assert "c/wall" not in out.maps and not (out.folder / "c_wall.jpg").exists()


def paint_table(folder, rows):
    columns = ["room_id", "surface", "paint", "white", "photos"]
    write_parquet(folder / "paint.parquet", pd.DataFrame(rows, columns=columns), {"house": "h"})
    return folder / "paint.parquet"


def test_rooms_are_as_the_walls_that_photos_show_without_those_of_unseen_bathrooms(tmp_path):
    rows = [(room, "wall", [0.5, 0.25, 0.1], False, "1.jpg") for room in "bd"]
    paint = paint_table(tmp_path, [*rows, ("a", "wall", [0.82, 0.82, 0.82], True, "2.jpg")])
    grey, brown = (np.full((8, 8, 3), colour, np.uint8) for colour in (150, (150, 100, 60)))
    names = {f"{room}/wall": grey if room in "ac" else brown for room in "abcde"}
    unseen = {"observed": False, "source": "exemplar of b, 1.0 dE2000 to the predicted colour"}
    entries = {"c/wall": unseen, "e/wall": unseen}
    out = Painted(paint, tmp_path, names, entries, bathrooms=["a", "c"])
    bath, room = (median_colour(out.tile(f"{name}/wall")) for name in "ce")
    assert np.ptp(bath) < 0.02 and np.ptp(room) > 0.2


def test_unseen_surfaces_follow_the_house():
    grey, white = np.full(3, 0.2), np.full(3, 0.8)
    key = SurfaceKey
    shown = {
        key("a", "wall"): grey,
        key("b", "wall"): grey,
        key("b", "wall.3"): grey / 2,
        key("a", "floor"): grey / 2,
        key("b", "floor"): grey / 4,
    }
    paint = {key("a", "wall"): white, key("a", "floor"): grey}
    unseen = {key("b", "wall"), key("b", "floor")}
    whites = plain_whites(paint, frozenset({key("a", "wall")}), unseen)
    gains = paint_gains(shown, paint, whites, white)
    assert gains[key("b", "wall")] * grey == pytest.approx(white)
    assert gains[key("b", "floor")] == pytest.approx([2.0] * 3)


def test_without_photos_walls_are_white_and_what_has_ready_crops_as_made():
    shown = {SurfaceKey("a", "wall"): np.full(3, 0.4), SurfaceKey("a", "floor"): np.full(3, 0.1)}
    gains = paint_gains(shown, {}, plain_whites({}, frozenset(), shown), [0.8] * 3)
    assert gains[SurfaceKey("a", "wall")] == pytest.approx([2.0] * 3)
    assert gains[SurfaceKey("a", "floor")] == pytest.approx([1.0] * 3)
    ready = paint_gains(shown, {}, set(), [0.8] * 3)
    assert ready[SurfaceKey("a", "wall")] == pytest.approx([1.0] * 3)


def test_unseen_doors_are_like_the_others():
    oak, white = np.array([0.3, 0.2, 0.1]), np.full(3, 0.8)
    seen = {SurfaceKey("1", "door"): oak, SurfaceKey("a", "wall"): white}
    assert set(door_paints(seen, frozenset())) == {"1"}
    seen[SurfaceKey("?photo/0", "door")] = oak  # a leaf whose opening is not known
    found = door_paints(seen, frozenset())
    assert found.keys() == {"1", ""} and found[""] == pytest.approx(oak)
    seen[SurfaceKey("3", "door")] = white
    assert "" not in door_paints(seen, frozenset({SurfaceKey("3", "door")}))


@pytest.mark.parametrize(("share", "known"), [(0.05, True), (0.004, False)])
def test_a_little_white_in_a_doorway_is_no_leaf(tmp_path, share, known):
    white, wood = (np.tile(np.float32(c), (32, 1)) for c in ((0.3, 0.28, 0.26), (0.09, 0.05, 0.02)))
    leaves = [
        PlaneColours("1.jpg", ("a",), "door", k, True, (name,), share, shown)
        for k, (name, shown) in enumerate((("one", white), ("two", wood)))
    ]
    walls = [plane("1.jpg", "a", name, (0.28, 0.26, 0.24)) for name in ("wall", "ceiling")]
    paint, _ = read_paint(paint_of(tmp_path, [*walls, *leaves]))
    doors = {key.room_id for key in paint if key.surface == "door"}
    assert doors == ({"one", "two"} if known else {"two"})


def test_doors_of_about_one_colour_are_of_one_material():
    oak, darker, blue = map(np.array, ((0.3, 0.2, 0.1), (0.26, 0.16, 0.07), (0.1, 0.2, 0.5)))
    seen = {SurfaceKey(name, "door"): c for name, c in zip("abc", (oak, darker, blue), strict=True)}
    found = door_paints(seen, frozenset())
    assert found["a"] == pytest.approx(np.sqrt(oak * darker))
    assert (found["a"] == found["b"]).all() and (found["c"] == blue).all()


def test_an_unseen_floor_is_lit_like_the_floor_that_looks_alike():
    key = SurfaceKey
    oak, slate = np.array([0.2, 0.12, 0.06]), np.full(3, 0.02)
    shown = {key("a", "floor"): oak, key("b", "floor"): slate, key("c", "floor"): 0.9 * oak}
    paint = {key("a", "floor"): 1.5 * oak, key("b", "floor"): 4.0 * slate}
    gains = paint_gains(shown, paint, set(), [0.8] * 3)
    assert gains[key("c", "floor")] == pytest.approx([1.5] * 3)
    # The texture of a floor whose crops are all too poor is a guess: its factor is no light.
    shown[key("d", "floor")], paint[key("d", "floor")] = 0.9 * oak, 5.0 * oak
    gains = paint_gains(shown, paint, set(), [0.8] * 3, {key("c", "floor"), key("d", "floor")})
    assert gains[key("c", "floor")] == pytest.approx([1.5] * 3)
    assert gains[key("d", "floor")] * shown[key("d", "floor")] == pytest.approx(5.0 * oak)
    only = {key(name, "floor"): shown[key(name, "floor")] for name in "cd"}
    gains = paint_gains(only, {key("d", "floor"): 5.0 * oak}, set(), [0.8] * 3, set(only))
    assert gains[key("c", "floor")] == pytest.approx([5.0 / 0.9] * 3)


def test_evidence_is_said_in_words():
    rooms = {"a", "dining_room"}

    def words(photos, white=False, coloured=False, **entry):
        key = SurfaceKey("a", "wall")
        return evidence_of(key, entry, photos, rooms, white=white, coloured=coloured)["words"]

    like = {"observed": False, "source": "exemplar of dining_room, 2.9 dE2000 to the colour"}
    assert words(["1", "2"], observed=True) == "seen in 2 photos"
    assert words(["1"], **like) == "colour seen in 1 photo, the rest guessed"
    doubt = "; its colour may be another"
    assert words(["1"], coloured=True, observed=True) == f"seen in 1 photo{doubt}"
    assert words([], **like) == f"guessed from the dining room{doubt}"
    assert words([], white=True, **like) == f"guessed: white, as most walls here{doubt}"


@pytest.mark.parametrize(
    ("substance", "shade", "kept"),
    [("carpet", 0.05, False), ("carpet", 0.2, True), ("wood", 0.05, True)],
)
def test_wear_of_a_plain_carpet_goes_and_its_pile_stays(paint, tmp_path, substance, shade, kept):
    wave = shade * np.sin(2 * np.pi * 4 * np.arange(128) / 128)[None, :, None]
    pile = np.random.default_rng(0).normal(0.0, 0.1, (128, 128, 1))
    tile = as_uint8(linear_to_srgb(np.exp(wave + pile) * [0.3, 0.28, 0.25]))
    out = Painted(paint, tmp_path, {"a/floor": tile}, {"a/floor": {"substance": substance}})
    log = np.log(srgb_to_linear(out.tile("a/floor"))[..., 1])
    left = log.mean(axis=0).std() / wave.std()
    assert left > 0.8 if kept else left < 0.45
    assert log.std(axis=0).mean() == pytest.approx(0.1, rel=0.2)
    assert ("a/floor" in out.maps) == (out.folder / "a_floor.jpg").exists() == kept


def test_smears_of_white_paint_go_and_its_relief_stays():
    x = np.arange(128) / 128
    smear, relief = 0.03 * np.sin(2 * np.pi * 4 * x), 0.03 * np.sin(2 * np.pi * 40 * x)
    for shade, kept in ((smear, False), (relief, True)):
        linear = np.broadcast_to(0.7 * np.exp(shade)[None, :, None], (128, 128, 3))
        image, pattern = plain(as_uint8(linear_to_srgb(linear)), np.full(3, 0.8), 128.0)
        assert pattern == pytest.approx(0.03 / 2**0.5, rel=0.2)
        left = np.log(srgb_to_linear(image)[..., 0]).std()
        assert left > 0.018 if kept else left < 0.01


def test_a_hook_in_a_wall_is_not_repeated_all_over_it():
    grain = np.random.default_rng(0).normal(0.0, 0.01, (128, 128, 1)) * np.ones(3)
    hook = grain.copy()
    hook[40:44, 50:58] = -0.3
    for shade, name in ((grain, "grain"), (hook, "hook")):
        image, _ = plain(as_uint8(linear_to_srgb(0.7 * np.exp(shade))), np.full(3, 0.8), 128.0)
        log = np.log(srgb_to_linear(image)[..., 0])
        assert log.std() == pytest.approx(0.01, rel=0.25), name
        assert np.abs(log - np.median(log)).max() < 0.06, name


@pytest.mark.parametrize("bare", ["a", ""])
def test_an_unseen_floor_of_a_kitchen_is_no_carpet(bare, tmp_path):
    rows = [(room, "floor", [0.4, 0.3, 0.2], False, "1.jpg") for room in ("a", "bed")]
    oak, pile = (np.full((8, 8, 3), colour, np.uint8) for colour in ((180, 120, 70), 150))
    names = {f"{room}/floor": oak if room == bare else pile for room in ("a", "bed", "k", "l")}
    like_bed = {"observed": False, "source": "exemplar of bed, 1.0 dE2000", "substance": "carpet"}
    entries = {"k/floor": like_bed, "l/floor": like_bed, "bed/floor": {"substance": "carpet"}}
    entries |= {"a/floor": {"substance": "wood" if bare else "carpet"}}
    paint = paint_table(tmp_path, rows)
    found = Painted(paint, tmp_path, names, entries, uncarpeted=["k"]).surfaces
    assert found["k/floor"]["substance"] == ("wood" if bare else "carpet")
    assert found["k/floor"]["evidence"]["like"] == (bare or "bed")
    assert found["l/floor"]["substance"] == "carpet"


LIKE_A = {"observed": False, "source": "exemplar of a, like a"}


@pytest.mark.parametrize("garages", [(), ("garage",)])
def test_an_unseen_floor_of_a_garage_is_grey(paint, tmp_path, garages):
    oak = np.full((64, 64, 3), (180, 120, 70), np.uint8)
    unseen = {"garage/floor": LIKE_A, "garage/wall": LIKE_A}
    tiles = dict.fromkeys(("a/floor", *unseen), oak)
    grey = Painted(paint, tmp_path, tiles, unseen, garages=garages).tile("garage/floor")
    assert (np.ptp(median_colour(grey)) < 0.02) == bool(garages)


@pytest.mark.parametrize("open_air", [(), ("a", "balcony")])
def test_an_unseen_balcony_has_no_carpet_and_no_wallpaper(paint, tmp_path, open_air):
    lilac = np.full((64, 64, 3), (190, 170, 200), np.uint8)
    lilac[::16] = 90
    unseen = {f"balcony/{name}": LIKE_A for name in ("floor", "wall", "ceiling")}
    tiles = dict.fromkeys(("a/floor", *unseen), lilac)
    out = Painted(paint, tmp_path, tiles, unseen, open_air=open_air)
    names = ("balcony/floor", "balcony/wall", "a/floor")
    floor, wall, seen = (median_colour(out.tile(name)) for name in names)
    joints, stone = out.tile("balcony/floor").std(), out.surfaces["balcony/floor"]
    if not open_air:
        assert joints > 10 and np.ptp(floor) > 0.05 and stone["evidence"]["like"] == "a"
        return
    assert joints < 1 and np.ptp(floor) < 0.02
    assert srgb_to_linear(floor) == pytest.approx(OUTDOORS["floor"][0], abs=0.02)
    assert wall * 255 == pytest.approx(RENDER, abs=2)  # as the outer faces beside it
    assert stone["substance"] == "tile" and stone["evidence"]["like"] is None
    assert "balcony/floor" not in out.maps and np.ptp(seen) > 0.05
