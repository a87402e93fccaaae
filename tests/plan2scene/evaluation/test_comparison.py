import shutil
from dataclasses import replace

import numpy as np
import pytest

from plan2scene.evaluation.measure import measure_tiles
from plan2scene.evaluation.references import reference_images
from plan2scene.house import SurfaceKey
from plan2scene.images import read_image
from plan2scene.io import read_json, read_parquet
from plan2scene.textures.house_textures import make_textures
from plan2scene.textures.inputs import HouseData, TextureSettings, Visible
from plan2scene.textures.methods import texture_methods

COMPARED = ("crop", "naivesynth", "synth", "synth-large", "exemplar")
HIDDEN = {"0.0": [], "0.6": ["p2.jpg"]}


@pytest.fixture(scope="module")
def compared(house, embeddings, compare, tmp_path_factory):
    """Return the house, what it shows at each drop, its tiles and its figures."""
    root = tmp_path_factory.mktemp("compared")
    house = replace(house, settings=TextureSettings(5, 64, {"crop": False, "naivesynth": True}))
    drops = {}
    for drop, hidden in HIDDEN.items():
        surfaces, propagated = (root / f"{name}_{drop}.parquet" for name in ("seen", "all"))
        house.select(embeddings, hidden, surfaces)
        house.propagate(surfaces, hidden, propagated)
        drops[drop] = Visible(propagated, hidden)
    metrics = compare(house, drops, COMPARED, root / "tiles", images=3)
    return house, drops, root / "tiles", read_parquet(metrics)[0]


def _files(folder):
    return {path.name: path.read_bytes() for path in folder.glob("*.*")}


@pytest.mark.parametrize("drop", HIDDEN)
@pytest.mark.parametrize("method", COMPARED)
def test_tiles_and_figures_are_those_of_the_stages(compared, tmp_path, method, drop):
    house, drops, folder, frame = compared
    # As rule textures does: files of its own, and the one weight file that it needs.
    weights = texture_methods()[method].weights
    models = {weights: house.models.decoders[weights]} if weights else {}
    inputs = HouseData(house.files).at(drops[drop], models, house.settings)
    make_textures(method, inputs, tmp_path / "alone")
    assert _files(tmp_path / "alone") == _files(folder / drop / method)
    entries = read_json(tmp_path / "alone" / "textures.json")["surfaces"]
    keys = {SurfaceKey(*name.rsplit("/", 1)): entry for name, entry in entries.items()}
    tiles = {key: read_image(tmp_path / "alone" / f"{key.filename}.png") for key in keys}
    observed = {key for key, entry in keys.items() if entry["observed"]}
    seen = reference_images(read_parquet(house.files.crops)[0], HIDDEN[drop])
    told = {"house_id": "h1", "method": method, "drop": drop}
    again = measure_tiles(tiles, observed, seen, house.models, **told)
    mine = frame[(frame["method"] == method) & (frame["drop"] == drop)]
    columns = ["room_id", "surface", "observed", "color", "freq", "tile", "subs"]
    assert mine[columns].values.tolist() == again[columns].values.tolist()
    assert np.array_equal(np.stack(mine["features"]), np.stack(again["features"]))


def test_tiles_that_are_ready_are_taken(compared, compare, tmp_path):
    house, drops, folder, _ = compared
    ready = {("0.0", "exemplar"): tmp_path / "shown"}
    shutil.copytree(folder / "0.0" / "exemplar", tmp_path / "shown")
    crop = next((folder / "0.0" / "crop").glob("*.png"))
    (tmp_path / "shown" / crop.name).write_bytes(crop.read_bytes())
    methods, tiles = ("crop", "exemplar"), tmp_path / "tiles"
    compare(house, {"0.0": drops["0.0"]}, methods, tiles, images=3, ready=ready)
    for method in methods:
        found, wanted = _files(tiles / "0.0" / method), _files(folder / "0.0" / method)
        changed = {name for name in wanted if found[name] != wanted[name]}
        assert found.keys() == wanted.keys()
        assert changed == ({crop.name} if method == "exemplar" else set())


def test_only_methods_that_draw_noise_get_more_images(compared):
    _, _, _, frame = compared
    for method, rows in frame.groupby("method"):
        lengths = {len(row) for row in rows["further_features"]}
        size = len(rows["features"].iloc[0])
        assert lengths == ({2 * size} if method in ("naivesynth", "synth") else {0})
