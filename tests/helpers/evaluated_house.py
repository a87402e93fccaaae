from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from sample_houses import rooms_in_a_row
from small_models import write_texture_models

from plan2scene.evaluation.measure import measure_textures, reference_features
from plan2scene.house import Door, House, Opening, Wall
from plan2scene.images import png_bytes
from plan2scene.io import write_parquet
from plan2scene.metrics.substance_network import SubstanceNetwork
from plan2scene.plans.scene_writer import write_scene_json
from plan2scene.propagation.graph_networks import PropagationNetwork, save_propagation
from plan2scene.propagation.type_means import TypeMeans
from plan2scene.textures.house_textures import table_textures
from plan2scene.textures.inputs import HouseFiles, TextureSettings
from plan2scene.textures.library import write_library
from plan2scene.textures.model.embedding import make_embeddings
from plan2scene.weights import save_model_file
from plan2scene_app.study.evaluated_house import EvaluatedHouse, Models

SIZE = 128
DOORWAY = Opening("", "door", 1.0, 1.9, 0.0, 2.0)
#: Four rooms in a row; doors lead from bed to hall to bath, none to the loft.
PLAN = House(
    "h1",
    rooms_in_a_row(bed="Bedroom", hall="Corridor", bath="Bathroom", loft="Closet"),
    tuple(
        Wall(f"w{i}", rooms, (x, 0.0), (x, 3.0), 2.5, openings=(replace(DOORWAY, id=f"d{i}"),))
        for i, (rooms, x) in enumerate(((("bed", "hall"), 3.0), (("hall", "bath"), 6.0)))
    ),
    (Door("bed", "d0", "hall"), Door("hall", "d1", "bath")),
)


def noise(seed, level):
    rng = np.random.default_rng(seed)
    return np.clip(rng.normal(level, 20, (SIZE, SIZE, 3)), 0, 255).astype(np.uint8)


CROPS = (
    ("a", "p1.jpg", "bed", "floor", 60),
    ("b", "p1.jpg", "bed", "floor", 110),
    ("c", "p2.jpg", "bed", "floor", 160),
    ("d", "p2.jpg", "hall", "floor", 200),
    ("e", "p2.jpg", "hall", "wall", 220),
    ("f", "p3.jpg", "bath", "floor", 30),
)


@pytest.fixture(scope="session")
def models(tmp_path_factory):
    root = tmp_path_factory.mktemp("models")
    paths = {
        name: root / f"{name}.safetensors"
        for name in ("texture", "naivesynth", "propagation", "features")
    }
    write_texture_models(paths["texture"], paths["naivesynth"])
    rng = np.random.default_rng(0)
    means = TypeMeans(
        rng.uniform(size=(12, 3, 11)).astype(np.float32),
        rng.normal(size=(12, 3, 8)).astype(np.float32),
    )
    network = PropagationNetwork(16, 2).eval()
    save_propagation(paths["propagation"], network, means, width=16, layers=2)
    network = SubstanceNetwork((4, 6), feature_dim=6)
    save_model_file(paths["features"], network.state_dict(), network.architecture)
    return Models(**paths, substances=paths["features"])


@pytest.fixture(scope="session")
def files(tmp_path_factory, models):
    root = tmp_path_factory.mktemp("house")
    names = ("scene.json", "crops.parquet", "library.parquet")
    made = HouseFiles("h1", *(root / name for name in names))
    write_scene_json(PLAN, made.scene)
    crops = pd.DataFrame(CROPS, columns=["crop_id", "photo", "room_id", "surface", "level"])
    crops["png"] = [png_bytes(noise(i, level)) for i, level in enumerate(crops.pop("level"))]
    write_parquet(made.crops, crops.assign(metres=0.5, sharpness=1.0), {"house": "h1"})
    inputs = made.crops, root / "embeddings.parquet", models.texture, models.naivesynth
    make_embeddings(*inputs, house="h1", dataset="d", seed=0)
    write_library(made.library, folder=None, per_substance=2, seed=0, size_px=128)
    references = root / "reference_features.parquet"
    reference_features(made.crops, models.features, references, dataset="d", house="h1")
    return made


@pytest.fixture(scope="session")
def house(files, models):
    return EvaluatedHouse("d", files, models, TextureSettings(0, 64), "house")


@pytest.fixture(scope="session")
def embeddings(files):
    return files.scene.with_name("embeddings.parquet")


@pytest.fixture(scope="session")
def references(files):
    return files.scene.with_name("reference_features.parquet")


@pytest.fixture(scope="session")
def compare():
    """Return what rules table_textures and metrics do: tiles to a folder, metrics beside it."""

    def compared(house, drops, methods, folder, **options):
        made = {"models": house.models.decoders, "settings": house.settings}
        table_textures(house.files, drops, methods, folder, **made, **options)
        metrics = folder.with_suffix(".parquet")
        hidden = {drop: visible.hidden_photos for drop, visible in drops.items()}
        told = dict(networks=house.models, dataset=house.dataset, house=house.files.house_id)
        measure_textures(folder, house.files.crops, hidden, methods, metrics, **told)
        return metrics

    return compared
