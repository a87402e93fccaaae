"""The propagation network returns what the authors' implementation returns (parity figures)."""

import numpy as np
import torch
from formula import formula_state

from plan2scene.propagation.networks import PropagationNetwork

ROOM_0 = [
    [0.024754293, -0.156382143, 0.082204133, -0.148976684, 0.103648163, -0.036828607]
    + [-0.211889639, -0.056307912, -0.185268283, -0.272552431, -0.182625264],
    [0.134393245, 0.311820811, -0.160095155, -0.136284545, -0.249168277, -0.312176079]
    + [0.020982552, -0.154467046, -0.184698299, 0.096395053, -0.085825153],
    [0.028601207, -0.02444605, 0.158350676, -0.121622629, 0.239293665, -0.028870851]
    + [0.050096277, 0.379922032, -0.115114138, -0.032846086, 0.189424947],
]
ROOM_3_WALL = [
    0.127270177,
    0.345494688,
    -0.179916486,
    -0.104277954,
    -0.239814624,
    -0.35621962,
    0.114294827,
    -0.154354796,
    -0.101112351,
    0.128907308,
    -0.170213148,
]


def formula_network() -> PropagationNetwork:
    network = PropagationNetwork().eval()
    network.load_state_dict(formula_state(network))
    return network


def test_same_output_as_the_reference():
    x = torch.sin(0.11 * (torch.arange(4 * 48, dtype=torch.float64) + 1)).float().reshape(4, 48)
    edges = torch.tensor([[0, 1, 1, 2, 1, 3], [1, 0, 2, 1, 3, 1]])
    with torch.no_grad():
        output = formula_network()(x, edges)
    assert output.shape == (4, 3, 11)
    assert np.allclose(output[0].numpy(), ROOM_0, atol=1e-4)
    assert np.allclose(output[3, 1].numpy(), ROOM_3_WALL, atol=1e-4)
    assert abs(float(output.sum()) - -3.5751821994781494) < 1e-3


def test_state_dict_has_the_released_names_and_shapes():
    shapes = {name: tuple(v.shape) for name, v in PropagationNetwork().state_dict().items()}
    assert shapes["conv1.weight"] == (3, 96, 96)
    assert shapes["conv1.rnn.weight_ih"] == (288, 96)
    assert shapes["linear1.0.weight"] == (96, 48)
    assert shapes["linear2.2.bias"] == (33,)


def test_no_edges_and_one_room_work():
    x = torch.zeros(1, 48)
    output = formula_network()(x, torch.zeros(2, 0, dtype=torch.int64))
    assert output.shape == (1, 3, 11)
    assert torch.isfinite(output).all()
