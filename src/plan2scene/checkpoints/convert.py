"""Converting a released checkpoint to a weight file of this program (docs/rent3dpp.md)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import torch

from plan2scene.checkpoints.reading import fitted_state, read_checkpoint, state_dict_of
from plan2scene.errors import InputError
from plan2scene.house import SUBSTANCES
from plan2scene.weights import save_model_file

if TYPE_CHECKING:
    from torch import nn

    from plan2scene.propagation.type_means import TypeMeans

#: Networks that have released checkpoints.
NETWORKS = ("texture", "naivesynth", "propagation", "vgg16", "inception")
#: End of the names of batch normalisation's training counters, which are left out.
_COUNTER = "num_batches_tracked"
#: What the authors' files call our substances.
_SYNONYMS = {"painted": "plaster", "plastered": "plaster", "smalltile": "tile"}


def convert_checkpoint(
    network: str,
    checkpoint: str | Path,
    output: str | Path,
    *,
    substances: Sequence[str] = SUBSTANCES,
    means: TypeMeans | None = None,
) -> None:
    """Write the weights of a released checkpoint as safetensors (float32) with our header.

    `network` is one of :data:`NETWORKS`: ``texture`` is version 1 or 2, which have the same
    structure, ``vgg16`` the substance classifier, ``inception`` InceptionV3 with tensor names of
    torchvision or pytorch-fid. `checkpoint` is a file of ``torch.save``; nothing in it is run.
    `substances` is the order of its substance classes; rows are sorted to ``house.SUBSTANCES``.
    `means` are stored with a ``propagation`` network, for NaiveSynth; no checkpoint has them.

    Raises InputError if the file contains code, lacks a tensor, or has one of another shape.
    """
    if network not in NETWORKS:
        raise InputError(f"a network ({', '.join(NETWORKS)})", repr(network))
    state = state_dict_of(read_checkpoint(checkpoint), checkpoint)
    order = _class_order(substances)
    if network == "propagation":
        _convert_propagation(state, checkpoint, output, means)
        return
    with torch.device("meta"):
        module, architecture, dropped, head = _structure(network, state, checkpoint)
    if network == "inception":
        state = {name: value for name, value in state.items() if not name.endswith(_COUNTER)}
    fitted = fitted_state(state, _shapes(module), checkpoint, dropped=dropped)
    for name in (f"{head}.weight", f"{head}.bias") if head else ():
        fitted[name] = fitted[name][order]
    save_model_file(output, fitted, architecture, half=False)


def _class_order(substances: Sequence[str]) -> list[int]:
    """Return the index of each of our substances in the checkpoint's order."""
    names = [_SYNONYMS.get(name, name) for name in substances]
    if sorted(names) != sorted(SUBSTANCES):
        expected = f"the substances {', '.join(SUBSTANCES)} in some order"
        raise InputError(expected, ", ".join(substances))
    return [names.index(name) for name in SUBSTANCES]


def _shapes(module: nn.Module) -> dict[str, tuple[int, ...]]:
    state = module.state_dict().items()
    return {name: tuple(value.shape) for name, value in state if not name.endswith(_COUNTER)}


def _structure(
    network: str, state: dict[str, torch.Tensor], checkpoint: str | Path
) -> tuple[nn.Module, dict[str, object], tuple[str, ...], str]:
    """Return a network, its header, prefixes of tensors that it leaves out, its substance layer.

    Texture models use the reference's noise (not periodic). InceptionV3 leaves out its class layer;
    the number of classes in the checkpoint gives the variant.
    """
    from plan2scene.metrics.inception import VARIANTS, InceptionV3
    from plan2scene.metrics.vgg import VggClassifier
    from plan2scene.textures.model.texture_model import Architecture, TextureModel

    if network == "vgg16":
        return VggClassifier(), {"network": network, "divisor": 1}, (), "classifier.6"
    if network == "inception":
        classes = next((len(v) for name, v in state.items() if name.endswith("fc.bias")), None)
        if classes not in VARIANTS:
            expected = f"fc.bias of {' or '.join(str(n) for n in VARIANTS)} classes"
            raise InputError(expected, str(classes or "none"), file=checkpoint)
        header = {"network": network, "variant": VARIANTS[classes], "divisor": 1}
        return InceptionV3(VARIANTS[classes]), header, ("fc.", "AuxLogits."), ""
    if network == "naivesynth":
        plain = Architecture(delta_hsv=False, substances=0, periodic=False)
        return TextureModel(plain), asdict(plain), ("substance_layer.",), ""
    full = Architecture(delta_hsv=True, substances=len(SUBSTANCES), periodic=False)
    return TextureModel(full), asdict(full), (), "substance_layer"


def _convert_propagation(
    state: dict[str, torch.Tensor],
    checkpoint: str | Path,
    output: str | Path,
    means: TypeMeans | None,
) -> None:
    """Write the propagation network with the means of training surfaces."""
    from plan2scene.propagation.graph_networks import PropagationNetwork, save_propagation

    if means is None:
        expected = "means over training surfaces with a propagation checkpoint"
        raise InputError(expected, "none", file=checkpoint)
    sizes = {"width": 96, "layers": 3}
    network = PropagationNetwork(sizes["width"], sizes["layers"])
    network.load_state_dict(fitted_state(state, _shapes(network), checkpoint))
    save_propagation(output, network, means, **sizes)
