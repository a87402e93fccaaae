"""Propagation models as they are trained and saved: a network and the room-type means."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import torch

from plan2scene.propagation.inference import GATED, POINTER, Network
from plan2scene.propagation.network import PropagationNetwork
from plan2scene.propagation.pointer import PointerNetwork
from plan2scene.propagation.prior import TypeMeans
from plan2scene.weights import save_model_file

_PRIOR = "prior."
#: Networks by the name that the files hold: the paper's, and the embedded one.
NETWORKS: Mapping[str, type[PropagationNetwork] | type[PointerNetwork]] = {
    GATED: PropagationNetwork,
    POINTER: PointerNetwork,
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


def network_of(module: PropagationNetwork | PointerNetwork) -> Network:
    """Return a module's parameters as they are now, for predictions."""
    arrays = {name: value.detach().cpu().numpy() for name, value in module.state_dict().items()}
    return Network(arrays, isinstance(module, PointerNetwork))
