import numpy as np
import pandas as pd
import pytest
import torch
from small_models import write_texture_models

from plan2scene.house import SUBSTANCES
from plan2scene.images import png_bytes
from plan2scene.io import read_parquet, write_parquet
from plan2scene.provenance import file_hash
from plan2scene.textures.model import texture_model
from plan2scene.textures.model.embedding import embed_crops, make_embeddings


@pytest.fixture(scope="module")
def model():
    torch.manual_seed(0)
    return texture_model.TextureModel(texture_model.Architecture(width=4)).eval()


def crops(count):
    return np.random.default_rng(0).integers(0, 256, (count, 128, 128, 3), dtype=np.uint8)


def crop_table(images):
    """Two photos; the last crop shows two rooms."""
    rows = [(f"floor/photo_0_crop{k}", "r1", png_bytes(image)) for k, image in enumerate(images)]
    rows.append((rows[-1][0], "r2", rows[-1][2]))
    table = pd.DataFrame(rows, columns=["crop_id", "room_id", "png"])
    return table.assign(photo="photo.jpg", surface="floor")


def test_embedding_ends_in_the_median_colour(model):
    images = crops(3)
    found = embed_crops(model, images)
    assert found.codes.shape == (3, 11)
    medians = np.sort(images.reshape(3, -1, 3), axis=1)[:, (128 * 128 - 1) // 2] / 255
    np.testing.assert_allclose(found.codes[:, 8:], medians, atol=1e-4)
    np.testing.assert_allclose(found.substance_probabilities.sum(1), 1.0, atol=1e-5)
    assert found.textureness.shape == (3,) and (found.textureness > 0).all()


def test_threads_change_nothing(model):
    images = np.concatenate([crops(3)] * 12)
    one, two = embed_crops(model, images, seed=4), embed_crops(model, images, seed=4, threads=2)
    assert one.codes.tobytes() == two.codes.tobytes()
    assert one.substance_probabilities.tobytes() == two.substance_probabilities.tobytes()
    assert one.textureness.tobytes() == two.textureness.tobytes()


def test_decoding_is_reproducible_and_depends_on_the_seed(model):
    codes = np.full((2, 11), 0.4, np.float32)
    first, second = texture_model.decode_textures(model, codes, [1, 2], 32)
    assert first.shape == (32, 32, 3) and not np.array_equal(first, second)
    assert np.array_equal(texture_model.decode_textures(model, codes[:1], [2], 32)[0], second)
    assert not np.array_equal(texture_model.noise_seeds([1]), texture_model.noise_seeds([2]))


def test_embeddings_of_a_house_with_and_without_crops(tmp_path, tmp_path_factory):
    folder = tmp_path_factory.mktemp("models")
    models = [folder / f"{name}.safetensors" for name in ("texture", "naivesynth")]
    write_texture_models(*models)
    table = crop_table(crops(3))
    write_parquet(tmp_path / "crops.parquet", table, {"house": "h"})
    output = tmp_path / "embeddings.parquet"
    make_embeddings(tmp_path / "crops.parquet", output, *models, house="h", dataset="d", seed=0)
    frame, metadata = read_parquet(output)
    assert frame["crop_id"].tolist() == table["crop_id"].tolist()
    assert frame["room_id"].tolist() == table["room_id"].tolist()
    assert [len(code) for code in frame["embedding"]] == [11] * 4
    assert [len(code) for code in frame["naive_embedding"]] == [8] * 4
    np.testing.assert_array_equal(frame["embedding"][2], frame["embedding"][3])
    best = [SUBSTANCES[int(np.argmax(p))] for p in frame["substance_probabilities"]]
    assert frame["substance"].tolist() == best and metadata["model"] == file_hash(models[0])
    again = tmp_path / "again.parquet"
    make_embeddings(tmp_path / "crops.parquet", again, *models, house="h", dataset="d", seed=0)
    assert again.read_bytes() == output.read_bytes()
    write_parquet(tmp_path / "crops.parquet", crop_table(crops(1)).iloc[:0], {"house": "h"})
    make_embeddings(tmp_path / "crops.parquet", output, *models, house="h", dataset="d", seed=0)
    frame, _ = read_parquet(output)
    assert len(frame) == 0 and "textureness" in frame.columns
