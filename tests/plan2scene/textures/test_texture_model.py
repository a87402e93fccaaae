import numpy as np
import torch

from plan2scene.textures.model.texture_model import Architecture, TextureModel


def test_state_dict_fits_released_checkpoints():
    with torch.device("meta"):
        state = TextureModel(Architecture(periodic=False)).state_dict()
    shapes = {name: tuple(value.shape) for name, value in state.items()}
    assert len(shapes) == 38 and shapes["encoder.conv1.weight"] == (64, 3, 7, 7)
    assert shapes["encoder.layer4.0.downsample.0.weight"] == (512, 256, 1, 1)
    assert shapes["encoder.layer4.1.conv2.weight"] == (512, 512, 3, 3)
    assert shapes["encoder.fc_bottleneck.weight"] == (8, 512)
    assert shapes["encoder.fc_final.weight"] == (96, 8)
    assert shapes["decoder.first_conv.layer.weight"] == (128, 112, 1, 1)
    assert shapes["decoder.res_blocks.3.layer.weight"] == (128, 128, 1, 1)
    assert shapes["decoder.last_conv.layer.bias"] == (3,)
    assert shapes["substance_layer.weight"] == (4, 8)


def test_tiles_have_the_embedding_s_colour_no_seam_and_come_in_any_size():
    torch.manual_seed(0)
    small = TextureModel(Architecture(width=8)).eval()
    code = torch.randn(2, 11, generator=torch.Generator().manual_seed(1))
    code[:, 8:] = 0.5
    seeds = torch.rand(2, 8, 3, generator=torch.Generator().manual_seed(2))
    with torch.no_grad():
        tile = small.decode(code, seeds, 64)
    assert tile.std() > 1e-3
    for axis in (2, 3):
        inside = tile.diff(dim=axis).abs().mean()
        assert (tile.select(axis, 0) - tile.select(axis, -1)).abs().mean() < 1.25 * inside
    code, seeds = torch.full((1, 11), 0.4), torch.full((1, 8, 3), 0.3)
    with torch.no_grad():
        coarse, fine = small.decode(code, seeds, 64), small.decode(code, seeds, 128)
    np.testing.assert_allclose(fine[:, :, ::2, ::2], coarse, atol=1e-4)
    rgb = torch.rand(1, 3, 128, 128) * 0.1 + torch.tensor([0.8, 0.4, 0.2]).view(1, 3, 1, 1)
    with torch.no_grad():
        embedding = small.encode(rgb).embedding
        tile = small.decode(embedding, torch.rand(1, 8, 3), 64)
    np.testing.assert_allclose(embedding[0, 8:], rgb.flatten(2).median(2).values[0], atol=1e-5)
    assert tile[0].mean((1, 2)).argmax() == 0
