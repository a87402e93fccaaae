import numpy as np
import pytest
from model_folder import HEADER, model_folder

from plan2scene.errors import InputError
from plan2scene_workshop.rendering.models import ModelShop, load_model, read_model_index


def test_a_piece_has_the_models_size_and_stands_with_its_back_at_zero(tmp_path):
    shop = ModelShop(read_model_index(model_folder(tmp_path), train=True))
    piece = shop.piece(np.random.default_rng(0), "table")
    points = np.concatenate([solid.vertices for _, solid, _ in piece.parts])
    assert np.ptp(points, axis=0) == pytest.approx(
        [piece.width, piece.height, piece.depth], rel=1e-5
    )
    assert points[:, 2].min() == pytest.approx(0, abs=1e-6) and 0.4 < piece.width < 0.9
    assert piece.parts[0][0] == "model" and piece.parts[0][2][0] > 4 * piece.parts[0][2][1]
    assert shop.piece(np.random.default_rng(0), "sofa") is None
    assert shop.piece(np.random.default_rng(0), "table", mounts=("wall",)) is None


@pytest.mark.parametrize(
    ("row", "expected"),
    [
        ("m0.glb,chair,wide,0.5,0.8,floor\n", "size in metres"),
        ("m0.glb,chair,-1,0.5,0.8,floor\n", "sizes of 0 to"),
        ("m0.glb,chair,1,0.5,0.8,roof\n", "mount"),
        ("../m0.glb,chair,1,0.5,0.8,floor\n", "plain file name"),
    ],
)
def test_bad_rows_are_one_line(tmp_path, row, expected):
    (tmp_path / "index.csv").write_text(HEADER + row)
    with pytest.raises(InputError, match=expected):
        read_model_index(tmp_path, train=True)


def test_files_that_are_no_models_are_refused(tmp_path):
    for name, content in (("a.glb", b"no model"), ("b.glb", b"glTF\x02\x00\x00\x00")):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(InputError, match="GLB model"):
            load_model(tmp_path / name)
