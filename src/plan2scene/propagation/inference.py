"""The propagation networks without torch, whose import takes longer than a house's predictions.

The same arithmetic as :mod:`plan2scene.propagation.network` and
:mod:`plan2scene.propagation.pointer`, which are what is trained; a test compares them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plan2scene.errors import InputError
from plan2scene.house import ROOM_TYPES, SUBSTANCES, SURFACES
from plan2scene.propagation.graph import EMBEDDING_SIZE, NODE_SIZE
from plan2scene.propagation.pairs import PAIR_SIZE
from plan2scene.propagation.prior import TypeMeans
from plan2scene.weights import read_model_arrays

#: Names of the networks in weight files: the paper's, and the embedded one.
GATED, POINTER = "gated", "pointer"
_PREFIX, _PRIOR = "network.", "prior."
#: Bounds of the pointer network's scores and scales: no component may become a spike.
MOST_SCORE, MOST_LOG_SCALE, LEAST_SCALE = 15.0, 2.0, 0.02
_KINDS = len(SURFACES)


@dataclass(frozen=True, eq=False)
class Network:
    """A network's parameters by the names of its state dict; `pointer` says which network."""

    arrays: Mapping[str, np.ndarray]
    pointer: bool

    def linear(self, name: str, x: np.ndarray) -> np.ndarray:
        """Return a linear layer's output."""
        result: np.ndarray = x @ self.arrays[f"{name}.weight"].T + self.arrays[f"{name}.bias"]
        return result

    @property
    def trunk(self) -> str:
        """Prefix of the paper's network in the names."""
        return "trunk." if self.pointer else ""


@dataclass(frozen=True, eq=False)
class MixtureArrays:
    """What :class:`plan2scene.propagation.pointer.Mixture` holds, as arrays."""

    own: np.ndarray
    log_own: np.ndarray
    log_copies: np.ndarray
    copy_scale: np.ndarray


def hidden_states(network: Network, x: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return what the paper's network knows of every room, (n, width), given (n, 48), (2, m)."""
    prefix = network.trunk
    state = _relu(network.linear(f"{prefix}linear1.0", x))
    state = _relu(network.linear(f"{prefix}linear1.2", state))
    source, target = edges
    rnn = f"{prefix}conv1.rnn"
    gate_in, gate_own = (network.arrays[f"{rnn}.weight_{name}"].T for name in ("ih", "hh"))
    bias_in, bias_own = (network.arrays[f"{rnn}.bias_{name}"] for name in ("ih", "hh"))
    for weight in network.arrays[f"{prefix}conv1.weight"]:
        messages = np.zeros_like(state)
        np.add.at(messages, target, (state @ weight)[source])
        reset_in, update_in, new_in = np.split(messages @ gate_in + bias_in, 3, axis=1)
        reset_own, update_own, new_own = np.split(state @ gate_own + bias_own, 3, axis=1)
        update = _sigmoid(update_in + update_own)
        new = np.tanh(new_in + _sigmoid(reset_in + reset_own) * new_own)
        state = (1.0 - update) * new + update * state
    return _relu(state)


def regression(network: Network, x: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return what the paper's network regresses, (n, 3, 11) float32."""
    return _regressed(network, hidden_states(network, x, edges))


def mixture(
    network: Network, x: np.ndarray, edges: np.ndarray, pairs: np.ndarray, facts: np.ndarray
) -> MixtureArrays:
    """Return the pointer network's mixture of every surface, as its ``forward``."""
    hidden = hidden_states(network, x, edges)
    target, source = pairs
    joined = np.concatenate([hidden[target], hidden[source], facts], axis=1)
    scores = network.linear("pair.2", _relu(network.linear("pair.0", joined)))
    visible = x[:, len(ROOM_TYPES) :].reshape(len(x), _KINDS, -1)[source, :, 0] != 0
    scores = np.where(visible, np.clip(scores, -MOST_SCORE, MOST_SCORE), -np.inf)
    none = np.clip(network.linear("none", hidden), -MOST_SCORE, MOST_SCORE)
    total = np.exp(none)
    np.add.at(total, target, np.exp(scores))
    total = np.log(total)
    raw = np.minimum(network.arrays["copy_scale"], MOST_LOG_SCALE)
    return MixtureArrays(
        own=_regressed(network, hidden),
        log_own=none - total,
        log_copies=scores - total[target],
        copy_scale=np.exp(raw) + LEAST_SCALE,
    )


def _regressed(network: Network, hidden: np.ndarray) -> np.ndarray:
    """Return the embeddings of hidden states."""
    inner = _relu(network.linear(f"{network.trunk}linear2.0", hidden))
    return network.linear(f"{network.trunk}linear2.2", inner).reshape(-1, _KINDS, EMBEDDING_SIZE)


def _relu(x: np.ndarray) -> np.ndarray:
    return np.maximum(x, 0.0)


def _sigmoid(x: np.ndarray) -> np.ndarray:
    """Return 1 / (1 + e^-x) without overflow."""
    result: np.ndarray = 0.5 * (1.0 + np.tanh(0.5 * x))
    return result


def read_propagation(path: str | Path) -> tuple[Network, TypeMeans]:
    """Return network and means of a file of ``save_propagation``; InputError for another's."""
    arrays, architecture = read_model_arrays(path)
    kind = architecture.get("network", GATED)
    if kind not in (GATED, POINTER):
        raise InputError(f"a propagation network of {GATED}, {POINTER}", str(kind), file=path)
    shapes = _shapes(kind, architecture)
    own = {k.removeprefix(_PREFIX): v for k, v in arrays.items() if k.startswith(_PREFIX)}
    wrong = sorted(
        name
        for name in shapes.keys() | own.keys()
        if name not in own or own[name].shape != shapes.get(name)
    )
    if wrong:
        found = f"{wrong[0]} {own[wrong[0]].shape if wrong[0] in own else 'missing'}"
        raise InputError("weights of a propagation network", found, file=path)
    try:
        means = TypeMeans(arrays[_PRIOR + "embedding"], arrays[_PRIOR + "naive"])
    except KeyError as error:
        raise InputError("means by room type", f"no {error}", file=path) from None
    return Network(own, kind == POINTER), means


def _shapes(kind: str, sizes: Mapping[str, int]) -> dict[str, tuple[int, ...]]:
    """Return the shapes of all parameters of a network."""
    width, layers = sizes.get("width", 96), sizes.get("layers", 3)
    outputs = _KINDS * EMBEDDING_SIZE
    linear = {"linear1.0": (width, NODE_SIZE), "linear1.2": (width, width)}
    linear |= {"linear2.0": (width, width), "linear2.2": (outputs, width)}
    shapes: dict[str, tuple[int, ...]] = {"conv1.weight": (layers, width, width)}
    for name in ("ih", "hh"):
        shapes[f"conv1.rnn.weight_{name}"] = (3 * width, width)
        shapes[f"conv1.rnn.bias_{name}"] = (3 * width,)
    if kind == POINTER:
        shapes = {f"trunk.{name}": shape for name, shape in shapes.items()}
        linear = {f"trunk.{name}": shape for name, shape in linear.items()}
        inner = sizes.get("pair_width", 64)
        linear |= {"pair.0": (inner, 2 * width + PAIR_SIZE), "pair.2": (_KINDS, inner)}
        linear |= {"none": (_KINDS, width), "own_scale": (outputs, width)}
        shapes["copy_scale"] = (_KINDS, EMBEDDING_SIZE)
        shapes |= {"centre": (EMBEDDING_SIZE,), "deviation": (EMBEDDING_SIZE,)}
    for name, shape in linear.items():
        shapes |= {f"{name}.weight": shape, f"{name}.bias": shape[:1]}
    return shapes


@dataclass(frozen=True, eq=False)
class SubstanceHead:
    """The texture model's head, which names predicted surfaces: (4, 8) weight and (4,) bias."""

    weight: np.ndarray
    bias: np.ndarray

    def name(self, embedding: np.ndarray) -> str:
        """Return the likeliest substance of an embedding (11,)."""
        code = np.asarray(embedding, dtype=np.float32)[: self.weight.shape[1]]
        return SUBSTANCES[int((self.weight @ code + self.bias).argmax())]


def read_substance_head(path: str | Path) -> SubstanceHead:
    """Return the substance head of a texture model file."""
    names = ("substance_layer.weight", "substance_layer.bias")
    arrays, _ = read_model_arrays(path, names)
    if len(arrays) != len(names):
        raise InputError("a texture model with a substance head", "none", file=path)
    return SubstanceHead(*(arrays[name] for name in names))
