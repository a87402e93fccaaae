"""Propagation models as files: a network and the room-type means."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TypeAlias

import torch

from plan2scene.errors import InputError
from plan2scene.propagation.network import PropagationNetwork
from plan2scene.propagation.pointer import PointerNetwork
from plan2scene.propagation.prior import TypeMeans
from plan2scene.weights import filled, load_model_file, save_model_file

Network: TypeAlias = PropagationNetwork | PointerNetwork
#: Networks by the name that the files hold: the paper's, and the embedded one.
NETWORKS: Mapping[str, type[PropagationNetwork] | type[PointerNetwork]] = {
    "gated": PropagationNetwork,
    "pointer": PointerNetwork,
}
_NETWORK, _PRIOR = "network.", "prior."


def save_propagation(path: str | Path, network: Network, means: TypeMeans, **sizes: int) -> None:
    """Write network and means as one safetensors file (float32: it is small).

    `sizes` are the arguments of the network's constructor.
    """
    kind = next(name for name, cls in NETWORKS.items() if type(network) is cls)
    state = {_NETWORK + name: value for name, value in network.state_dict().items()}
    state[_PRIOR + "embedding"] = torch.from_numpy(means.embedding)
    state[_PRIOR + "naive"] = torch.from_numpy(means.naive)
    save_model_file(path, state, {"network": kind, **sizes}, half=False)


def load_propagation(path: str | Path) -> tuple[Network, TypeMeans]:
    """Return network and means of a file of :func:`save_propagation`; InputError for another's."""
    state, sizes = load_model_file(path)
    kind = str(sizes.pop("network", "gated"))
    if kind not in NETWORKS:
        raise InputError(f"a propagation network of {', '.join(NETWORKS)}", str(kind), file=path)
    own = {k.removeprefix(_NETWORK): v for k, v in state.items() if k.startswith(_NETWORK)}
    network = filled(lambda: NETWORKS[kind](**sizes), own, "a propagation network", path)
    means = [state.get(_PRIOR + name) for name in ("embedding", "naive")]
    if means[0] is None or means[1] is None:
        raise InputError("means by room type", "none", file=path)
    return network, TypeMeans(means[0].numpy(), means[1].numpy())
