import numpy as np
import pandas as pd
import pytest

from plan2scene.errors import InputError
from plan2scene.images import png_bytes
from plan2scene.io import read_parquet, write_parquet
from plan2scene.textures.observed_surfaces import select_surfaces, surface_embedding

# (photo, room, surface, textureness, grey level, metres)
CROPS = [
    ("a.jpg", "r1", "floor", 0.5, 100, 1.0),
    ("a.jpg", "r1", "floor", 0.2, 200, 0.5),
    ("b.jpg", "r1", "floor", 0.1, 110, float("nan")),
    ("b.jpg", "r1", "wall", 0.3, 90, float("nan")),
    ("b.jpg", "r2", "wall", 0.3, 90, float("nan")),
]


@pytest.fixture
def files(tmp_path):
    names = ["photo", "room_id", "surface", "textureness", "grey", "metres"]
    table = pd.DataFrame(CROPS, columns=names)
    table["crop_id"] = [f"{r.surface}/{r.photo[0]}_0_crop{r.Index}" for r in table.itertuples()]
    table["png"] = [png_bytes(np.full((128, 128, 3), grey, np.uint8)) for grey in table["grey"]]
    table["embedding"] = [np.full(11, k, np.float32) for k in table.index]
    table["naive_embedding"] = [np.full(8, k, np.float32) for k in table.index]
    table["substance_probabilities"] = [np.eye(4, dtype=np.float32)[k % 2] for k in table.index]
    crops, embeddings = tmp_path / "crops.parquet", tmp_path / "embeddings.parquet"
    write_parquet(crops, table[["crop_id", "photo", "room_id", "surface", "metres", "png"]], {})
    own = ["embedding", "naive_embedding", "substance_probabilities", "textureness"]
    write_parquet(embeddings, table[["crop_id", *own]], {"model": "m"})
    return embeddings, crops, tmp_path / "surfaces.parquet"


def select(files, hidden=()):
    embeddings, crops, output = files
    select_surfaces(embeddings, crops, hidden, output, house="h", dataset="d", threads=2)
    frame, metadata = read_parquet(output)
    return frame.set_index(["room_id", "surface"]), metadata


def test_the_crop_of_least_textureness_of_visible_photos_wins(files):
    frame, metadata = select(files)
    assert frame.index.tolist() == [("r1", "floor"), ("r1", "wall"), ("r2", "wall")]
    row = frame.loc[("r1", "floor")]
    assert row["crop_id"] == "floor/b_0_crop2"
    assert row["embedding"].tolist() == [2.0] * 8 + [1.0] * 3  # colour: the median of all
    assert row["naive_embedding"].tolist() == [1.0] * 8
    assert row["medoid_id"] == "floor/b_0_crop2"  # grey 110 is nearest to the mean 136.7
    assert row["substance"] == "wood" and row["n_crops"] == 3
    assert row["metres"] == 0.75  # the chosen crop has none: the median of the others
    assert np.isnan(frame.loc[("r2", "wall"), "metres"]) and metadata["model"] == "m"
    frame, _ = select(files, hidden=["b.jpg"])
    assert frame.index.tolist() == [("r1", "floor")]
    row = frame.loc[("r1", "floor")]
    assert row["crop_id"] == "floor/a_0_crop1" and row["metres"] == 0.5
    assert row["naive_embedding"].tolist() == [0.5] * 8
    frame, _ = select(files, hidden=["a.jpg", "b.jpg"])
    assert len(frame) == 0
    assert {"crop_id", "embedding", "metres"} <= set(frame.columns)


def test_embeddings_of_other_crops_are_refused(files, tmp_path):
    embeddings, crops, output = files
    table, _ = read_parquet(embeddings)
    write_parquet(embeddings, table.iloc[1:], {})
    with pytest.raises(InputError, match="house h"):
        select_surfaces(embeddings, crops, (), output, house="h", dataset="d")


def test_all_crops_that_are_not_burned_out_give_the_colour():
    codes = np.arange(44, dtype=np.float32).reshape(4, 11)
    scores, clipped = np.array([0.3, 0.1, 0.2, 0.05]), np.array([0.0, 0.1, 0.0, 0.9])
    index, embedding = surface_embedding(codes, scores, clipped)
    assert index == 1 and embedding[:8].tolist() == codes[1, :8].tolist()
    assert embedding[8:].tolist() == np.median(codes[:3, 8:], axis=0).tolist()
    _, burned = surface_embedding(codes, scores, np.full(4, 0.9))
    assert burned[8:].tolist() == np.median(codes[:, 8:], axis=0).tolist()
    assert codes[1, 8] == 19.0  # the crops' own are left alone
