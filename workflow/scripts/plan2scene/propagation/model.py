"""Loading the propagation model: the network and the room-type means in one file."""

from __future__ import annotations

from pathlib import Path

import torch
from torch import nn

from plan2scene.errors import InputError
from plan2scene.house import SUBSTANCES
from plan2scene.propagation.network import PropagationNetwork
from plan2scene.propagation.prior import TypeMeans
from plan2scene.weights import load_model_file, save_model_file

_PRIOR = "prior."


def save_propagation(
    path: str | Path, network: PropagationNetwork, means: TypeMeans, *, width: int, layers: int
) -> None:
    """Write network and means as one safetensors file (float32: it is small)."""
    state = {f"network.{k}": v for k, v in network.state_dict().items()}
    state[_PRIOR + "embedding"] = torch.from_numpy(means.embedding)
    state[_PRIOR + "naive"] = torch.from_numpy(means.naive)
    save_model_file(path, state, {"width": width, "layers": layers}, half=False)


def load_propagation(path: str | Path) -> tuple[PropagationNetwork, TypeMeans]:
    """Return (network in evaluation mode, means) of a file of :func:`save_propagation`."""
    state, architecture = load_model_file(path)
    try:
        network = PropagationNetwork(**architecture)
        network.load_state_dict(
            {k.removeprefix("network."): v for k, v in state.items() if k.startswith("network.")}
        )
        means = TypeMeans(state[_PRIOR + "embedding"].numpy(), state[_PRIOR + "naive"].numpy())
    except (TypeError, KeyError, RuntimeError) as error:
        raise InputError("weights of a propagation network", str(error), file=path) from None
    return network.eval(), means


def load_substance_head(path: str | Path) -> nn.Linear:
    """Return the substance head (8 -> 4) of a texture model file: names predicted surfaces."""
    state, _ = load_model_file(path)
    if state.get("substance_layer.weight") is None:
        raise InputError("a texture model with a substance head", "none", file=path)
    head = nn.Linear(8, len(SUBSTANCES))
    head.load_state_dict(
        {"weight": state["substance_layer.weight"], "bias": state["substance_layer.bias"]}
    )
    return head.eval()
