"""Loading a propagation model: a network and the room-type means in one file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import torch
from torch import nn

from plan2scene.errors import InputError
from plan2scene.house import SUBSTANCES
from plan2scene.propagation.network import PropagationNetwork
from plan2scene.propagation.pointer import PointerNetwork
from plan2scene.propagation.prior import TypeMeans
from plan2scene.weights import load_model_file, save_model_file

_PRIOR = "prior."
#: Networks by the name that the files hold: the paper's, and the embedded one.
NETWORKS: Mapping[str, type[PropagationNetwork] | type[PointerNetwork]] = {
    "gated": PropagationNetwork,
    "pointer": PointerNetwork,
}


def save_propagation(
    path: str | Path,
    network: PropagationNetwork | PointerNetwork,
    means: TypeMeans,
    **sizes: int,
) -> None:
    """Write network and means as one safetensors file (float32: it is small).

    `sizes` are the arguments of the network's constructor.
    """
    kind = next(name for name, cls in NETWORKS.items() if type(network) is cls)
    state = {f"network.{k}": v for k, v in network.state_dict().items()}
    state[_PRIOR + "embedding"] = torch.from_numpy(means.embedding)
    state[_PRIOR + "naive"] = torch.from_numpy(means.naive)
    save_model_file(path, state, {"network": kind, **sizes}, half=False)


def load_propagation(
    path: str | Path,
) -> tuple[PropagationNetwork | PointerNetwork, TypeMeans]:
    """Return (network in evaluation mode, means) of a file of :func:`save_propagation`."""
    state, architecture = load_model_file(path)
    sizes: dict[str, Any] = dict(architecture)
    kind = sizes.pop("network", "gated")
    if kind not in NETWORKS:
        raise InputError(f"a propagation network of {', '.join(NETWORKS)}", str(kind), file=path)
    try:
        network = NETWORKS[kind](**sizes)
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
