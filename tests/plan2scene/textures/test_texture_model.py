"""The texture model against the reference implementation, and what our variant adds."""

import numpy as np
import pytest
import torch
from formula import formula_crop, formula_state
from PIL import Image

from plan2scene.errors import InputError
from plan2scene.textures.model.texture_model import (
    Architecture,
    TextureModel,
    architecture_header,
    fast_decoding,
    load_texture_model,
    low_precision_is_fast,
)
from plan2scene.weights import save_model_file

# Figures that the reference implementation returns on a CPU for weights and a crop given by
# formulas (tests/helpers/formula.py); networks agree up to 1e-4.
EMBEDDING = [
    1.2627286911010742,
    1.3801169395446777,
    0.44629013538360596,
    0.5725345611572266,
    2.2141711711883545,
    -0.543013334274292,
    -0.24174371361732483,
    -0.09874101728200912,
    0.45098039507865906,
    0.3482721745967865,
    0.2519800364971161,
]
LOGITS = [0.8494102358818054, -0.22475911676883698, -0.7282568216323853, -0.5147141814231873]
CHANNEL_MEANS = [0.29308897256851196, -0.4792734384536743, -0.5299186110496521]
PICKS = [  # channel, row, column, value of 2 RGB - 1
    (0, 0, 0, 0.23240172863006592),
    (0, 0, 127, 0.3109496831893921),
    (0, 1, 50, 0.3223845958709717),
    (0, 63, 2, 0.2876497507095337),
    (0, 64, 0, 0.26132214069366455),
    (0, 64, 127, 0.2874523401260376),
    (0, 127, 50, 0.3843482732772827),
    (1, 0, 2, -0.5710693001747131),
    (1, 1, 0, -0.48483991622924805),
    (1, 1, 127, -0.5328444838523865),
    (1, 63, 50, -0.5162883996963501),
    (1, 64, 2, -0.5042094588279724),
    (1, 127, 0, -0.503136932849884),
    (1, 127, 127, -0.409664511680603),
    (2, 0, 50, -0.45014339685440063),
    (2, 1, 2, -0.5214052200317383),
    (2, 63, 0, -0.5348287224769592),
    (2, 63, 127, -0.5247616767883301),
    (2, 64, 50, -0.5213954448699951),
    (2, 127, 2, -0.575185239315033),
]


@pytest.fixture(scope="module")
def reference() -> TextureModel:
    model = TextureModel(Architecture(periodic=False))
    model.load_state_dict(formula_state(model))
    return model.eval()


@pytest.fixture(scope="module")
def small() -> TextureModel:
    torch.manual_seed(0)
    return TextureModel(Architecture(width=8)).eval()


def test_state_dict_fits_released_checkpoints(reference: TextureModel) -> None:
    shapes = {name: tuple(value.shape) for name, value in reference.state_dict().items()}
    assert len(shapes) == 38
    assert shapes["encoder.conv1.weight"] == (64, 3, 7, 7)
    assert shapes["encoder.layer4.0.downsample.0.weight"] == (512, 256, 1, 1)
    assert shapes["encoder.layer4.1.conv2.weight"] == (512, 512, 3, 3)
    assert shapes["encoder.fc_bottleneck.weight"] == (8, 512)
    assert shapes["encoder.fc_final.weight"] == (96, 8)
    assert shapes["decoder.first_conv.layer.weight"] == (128, 112, 1, 1)
    assert shapes["decoder.res_blocks.3.layer.weight"] == (128, 128, 1, 1)
    assert shapes["decoder.last_conv.layer.bias"] == (3,)
    assert shapes["substance_layer.weight"] == (4, 8)


def test_embedding_substance_and_output_of_the_reference(reference: TextureModel) -> None:
    hsv8 = np.array(Image.fromarray(formula_crop()).convert("HSV"))
    hsv = torch.from_numpy(hsv8).permute(2, 0, 1)[None].float() / 255.0
    seeds = torch.from_numpy(np.float32((np.arange(24) * 0.6180339887) % 1)).view(1, 8, 3)
    with torch.no_grad():
        encoding = reference.encode_hsv(hsv)
        signed = 2.0 * reference.decode(encoding.embedding, seeds)[0].numpy() - 1.0
    np.testing.assert_allclose(encoding.embedding[0], EMBEDDING, atol=1e-4)
    assert encoding.logits is not None
    np.testing.assert_allclose(encoding.logits[0], LOGITS, atol=1e-4)
    np.testing.assert_allclose(signed.mean((1, 2)), CHANNEL_MEANS, atol=1e-4)
    for channel, row, column, value in PICKS:
        assert signed[channel, row, column] == pytest.approx(value, abs=1e-4)


def test_decoded_tile_has_no_seam(small: TextureModel) -> None:
    code = torch.randn(2, 11, generator=torch.Generator().manual_seed(1))
    code[:, 8:] = 0.5
    seeds = torch.rand(2, 8, 3, generator=torch.Generator().manual_seed(2))
    with torch.no_grad():
        tile = small.decode(code, seeds, 64)
    assert tile.std() > 1e-3
    for axis in (2, 3):
        inside = tile.diff(dim=axis).abs().mean()
        across = (tile.select(axis, 0) - tile.select(axis, -1)).abs().mean()
        assert across < 1.25 * inside


def test_more_pixels_draw_the_same_tile(small: TextureModel) -> None:
    code, seeds = torch.full((1, 11), 0.4), torch.full((1, 8, 3), 0.3)
    with torch.no_grad():
        coarse, fine = small.decode(code, seeds, 64), small.decode(code, seeds, 128)
    np.testing.assert_allclose(fine[:, :, ::2, ::2], coarse, atol=1e-4)


def test_window_is_a_part_of_the_tile(small: TextureModel) -> None:
    code, seeds = torch.full((1, 11), 0.4), torch.full((1, 8, 3), 0.3)
    rows, columns = slice(5, 25), slice(32, 64)
    with torch.no_grad():
        whole = small.decode(code, seeds, 64)
        part = small.decode(code, seeds, 64, (rows, columns))
    np.testing.assert_allclose(part, whole[:, :, rows, columns], atol=1e-5)


def test_naive_model_has_no_colour_and_no_head() -> None:
    model = TextureModel(Architecture(width=8, delta_hsv=False, substances=0))
    assert model.embedding_dim == 8
    crops = torch.rand(2, 3, 128, 128)
    encoding = model.encode(crops)
    assert encoding.embedding.shape == (2, 8)
    assert encoding.logits is None
    tile = model.decode(encoding.embedding, torch.rand(2, 8, 3), 32).detach()
    assert tile.shape == (2, 3, 32, 32)
    assert 0 <= float(tile.min()) <= float(tile.max()) <= 1


def test_colour_of_the_texture_is_the_embedding_s(small: TextureModel) -> None:
    rgb = torch.rand(1, 3, 128, 128) * 0.1 + torch.tensor([0.8, 0.4, 0.2]).view(1, 3, 1, 1)
    with torch.no_grad():
        embedding = small.encode(rgb).embedding
        tile = small.decode(embedding, torch.rand(1, 8, 3), 64)
    np.testing.assert_allclose(embedding[0, 8:], rgb.flatten(2).median(2).values[0], atol=1e-5)
    assert tile[0].mean((1, 2)).argmax() == 0


def test_low_precision_is_close(small: TextureModel) -> None:
    code, seeds = torch.full((1, 11), 0.4), torch.full((1, 8, 3), 0.3)
    with torch.no_grad():
        exact = small.decode(code, seeds, 32)
        small.decoder.low_precision = True
        rounded = small.decode(code, seeds, 32)
        small.decoder.low_precision = False
    assert 0 < float((exact - rounded).abs().max()) < 0.03


def test_released_networks_decode_in_full_precision(small: TextureModel) -> None:
    released = TextureModel(Architecture(width=4, periodic=False))
    with fast_decoding(released):
        assert not released.decoder.low_precision
    with pytest.raises(ZeroDivisionError), fast_decoding(small):
        assert small.decoder.low_precision == low_precision_is_fast()
        raise ZeroDivisionError
    assert not small.decoder.low_precision


def test_gradients_reach_the_encoder_through_the_noise(small: TextureModel) -> None:
    code = torch.zeros(1, 11, requires_grad=True)
    small.decode(code, torch.rand(1, 8, 3), 16).square().sum().backward()
    assert code.grad is not None
    assert float(code.grad.abs().sum()) > 0


def test_weights_round_trip(small: TextureModel, tmp_path) -> None:
    path = tmp_path / "texture.safetensors"
    save_model_file(path, small.state_dict(), architecture_header(small), half=False)
    loaded = load_texture_model(path)
    assert loaded.architecture == small.architecture
    code, seeds = torch.full((1, 11), 0.4), torch.full((1, 8, 3), 0.3)
    with torch.no_grad():
        assert torch.equal(loaded.decode(code, seeds, 16), small.decode(code, seeds, 16))


@pytest.mark.parametrize("change", [{"width": 16}, {"unknown": 1}])
def test_weights_that_do_not_fit_are_refused(small: TextureModel, tmp_path, change) -> None:
    path = tmp_path / "texture.safetensors"
    save_model_file(path, small.state_dict(), {**architecture_header(small), **change})
    with pytest.raises(InputError, match=r"texture\.safetensors"):
        load_texture_model(path)


def test_statistics_encoder_tells_patterns_apart_more_than_shades() -> None:
    torch.manual_seed(0)
    model = TextureModel(Architecture(width=16, encoder="statistics")).eval()
    wave = torch.sin(torch.arange(128) * 0.8)
    stripes = 0.5 + 0.1 * wave.view(1, 1, 1, -1).expand(1, 3, 128, 128)
    with torch.no_grad():
        across = model.encode(stripes).embedding
        down = model.encode(stripes.transpose(2, 3)).embedding
        darker = model.encode(stripes - 0.2).embedding
    assert across.shape == (1, 11)
    pattern, shade = ((other - across)[:, :8].abs().max() for other in (down, darker))
    assert float(pattern) > 0.01
    assert float(shade) < 0.2 * float(pattern)
    np.testing.assert_allclose(darker[:, 8:], across[:, 8:] - 0.2, atol=1e-5)


def test_unknown_encoder_is_refused() -> None:
    with pytest.raises(ValueError, match="vit"):
        TextureModel(Architecture(encoder="vit"))
