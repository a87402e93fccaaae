import csv
from pathlib import Path

import pandas as pd
import pytest
import torch
from clones import demo_rows, make_clone, photos_of, write_table
from rent3dpp_copy import write_rent3dpp_copy

from plan2scene.images import png_bytes
from plan2scene.io import write_parquet
from plan2scene.materials import random_material
from plan2scene.propagation.graph_networks import PropagationNetwork, load_propagation
from plan2scene.textures.model.texture_model import Architecture, TextureModel

TABLE = "results/rent3dpp/tables/paper_table.csv"
CONFIG = ("--configfile", "config/rent3dpp.yaml", "two_seeds.yaml", "--config")


def write_crops(results, row):
    kinds = {"floor": "wood", "wall": "plaster", "ceiling": "plaster"}
    tiles = {name: random_material(kinds[name], 3, size_px=128).albedo for name in kinds}
    rows = [
        {"crop_id": f"{name}/{Path(photo).stem}_0_crop0", "png": png_bytes(tile)}
        for photo in photos_of(row)
        for name, tile in tiles.items()
    ]
    write_parquet(results / "houses" / row["house"] / "crops.parquet", pd.DataFrame(rows), {})


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """Return a clone beside a Rent3D++ copy (a training and a test house) and checkpoints."""
    root = tmp_path_factory.mktemp("rent3dpp")
    clone = make_clone(root / "clone", [])
    train, test = demo_rows()[:2]
    source = make_clone(root / "source", [train, test]).root / "data"
    write_table(source, [train | {"split": "train"}, test])
    for row in (train, test):
        write_crops(root / "earlier", row)
    write_rent3dpp_copy(source, root / "copy", crops=root / "earlier")
    torch.manual_seed(0)
    plain = {"periodic": False}
    networks = {
        "texture": TextureModel(Architecture(**plain)),
        "naivesynth": TextureModel(Architecture(**plain, delta_hsv=False, substances=0)),
        "propagation": PropagationNetwork(),
    }
    for name, network in networks.items():
        torch.save({"model_state_dict": network.state_dict(), "epoch": 1}, root / f"{name}.ckpt")
    (clone.root / "two_seeds.yaml").write_text("metrics: {fid_seeds: 2}\n")  # 24 take long
    return clone


def test_one_command_makes_the_table(place):
    root = place.root.parent
    train, test = demo_rows()[:2]
    paths = {name: root / f"{name}.ckpt" for name in ("texture", "naivesynth", "propagation")}
    official = ", ".join(f"{name}: {path}" for name, path in paths.items())
    told = f"dataset={{root: {root / 'copy'}}}", "weights=official", f"official={{{official}}}"
    run = place.snakemake(TABLE, *CONFIG, *told, "methods=[synth]")
    assert run.returncode == 0, run.stdout[-3000:]
    rows = list(csv.DictReader((place.root / TABLE).read_text().splitlines()))
    assert {row["method"] for row in rows} == {"synth"}
    assert all(int(row["images"]) == 2 * int(row["n"]) for row in rows)
    assert "\\bottomrule" in (place.root / TABLE).with_suffix(".tex").read_text()
    assert not (root / "copy/input/houses.tsv").exists()
    made = place.root / "results/rent3dpp"
    crops = pd.read_parquet(made / "houses" / test["house"] / "crops.parquet")
    assert set(crops["photo"]) == set(photos_of(test))
    assert not (made / "houses" / test["house"] / "masks").exists()
    assert not (made / "drop_0.0/synth" / train["house"]).exists()
    assert not (made / "texture_library.parquet").exists()  # no method of the table takes a tile
    state = torch.load(root / "propagation.ckpt", weights_only=True)["model_state_dict"]
    network, _ = load_propagation(made / "weights/propagation.safetensors")
    assert all(torch.equal(value, state[name]) for name, value in network.state_dict().items())


def test_without_ready_crops_they_are_sampled(place):
    copy = place.root.parent / "bare"
    copy.mkdir()
    (copy / "input").symlink_to(place.root.parent / "copy/input")
    other = "dataset={root: " + str(copy) + ", name: other}"
    jobs = place.jobs(TABLE.replace("rent3dpp", "other"), *CONFIG, other, "methods=[crop]")
    assert ("masks", demo_rows()[1]["house"]) in jobs
