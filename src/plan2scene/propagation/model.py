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
from plan2scene.weights import load_model_file, save_model_file

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
    kind = sizes.pop("network", "gated")
    if kind not in NETWORKS:
        raise InputError(f"a propagation network of {', '.join(NETWORKS)}", str(kind), file=path)
    own = {k.removeprefix(_NETWORK): v for k, v in state.items() if k.startswith(_NETWORK)}
    try:
        with torch.device("meta"):  # no values to draw: the file's take their place
            network = NETWORKS[kind](**sizes)
        network.to_empty(device="cpu").load_state_dict(own)
        means = TypeMeans(state[_PRIOR + "embedding"].numpy(), state[_PRIOR + "naive"].numpy())
    except (RuntimeError, TypeError) as error:
        found = " ".join(str(error).split("\n\t")[:2])
        raise InputError("weights of a propagation network", found, file=path) from None
    except KeyError as error:
        raise InputError("means by room type", f"no {error}", file=path) from None
    return network.eval(), means
