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

    from plan2scene.propagation.prior import TypeMeans

#: Networks that have released checkpoints.
NETWORKS = ("texture", "naivesynth", "propagation", "vgg16", "inception")
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

    Parameters
    ----------
    network : str
        One of :data:`NETWORKS`; ``texture`` is version 1 or 2, which have one structure,
        ``vgg16`` the substance classifier, ``inception`` no checkpoint of the authors but
        InceptionV3's weights as torchvision or pytorch-fid name them.
    checkpoint : path
        File of ``torch.save``; nothing in it is run.
    output : path
    substances : sequence of str
        Order of the checkpoint's substance classes; rows are sorted to ``house.SUBSTANCES``.
    means : TypeMeans, optional
        For ``propagation``: means over training surfaces, which our file holds beside the network
        (NaiveSynth's unobserved surfaces) and no checkpoint has.

    Raises
    ------
    InputError
        A file that carries code, misses a tensor, or has one of another shape.
    """
    if network not in NETWORKS:
        raise InputError(f"a network ({', '.join(NETWORKS)})", repr(network))
    state = state_dict_of(read_checkpoint(checkpoint), checkpoint)
    order = _class_order(substances)
    if network == "propagation":
        _convert_propagation(state, checkpoint, output, means)
    elif network == "vgg16":
        _convert_classifier(state, checkpoint, output, order)
    elif network == "inception":
        _convert_inception(state, checkpoint, output)
    else:
        _convert_texture(state, checkpoint, output, order, naive=network == "naivesynth")


def _class_order(substances: Sequence[str]) -> list[int]:
    """Return where each of our substances stands in the checkpoint's order."""
    names = [_SYNONYMS.get(name, name) for name in substances]
    if sorted(names) != sorted(SUBSTANCES):
        expected = f"the substances {', '.join(SUBSTANCES)} in some order"
        raise InputError(expected, ", ".join(substances))
    return [names.index(name) for name in SUBSTANCES]


def _shapes(module: nn.Module) -> dict[str, tuple[int, ...]]:
    return {name: tuple(value.shape) for name, value in module.state_dict().items()}


def _convert_texture(
    state: dict[str, torch.Tensor],
    checkpoint: str | Path,
    output: str | Path,
    order: list[int],
    *,
    naive: bool,
) -> None:
    """Write a texture model with the reference's noise; a substance head sorted to our order."""
    from plan2scene.textures.model.network import Architecture, TextureModel

    architecture = Architecture(
        delta_hsv=not naive, substances=0 if naive else len(SUBSTANCES), periodic=False
    )
    with torch.device("meta"):
        shapes = _shapes(TextureModel(architecture))
    dropped = ("substance_layer.",) if naive else ()
    fitted = fitted_state(state, shapes, checkpoint, dropped=dropped)
    if not naive:
        for name in ("substance_layer.weight", "substance_layer.bias"):
            fitted[name] = fitted[name][order]
    save_model_file(output, fitted, asdict(architecture), half=False)


def _convert_propagation(
    state: dict[str, torch.Tensor],
    checkpoint: str | Path,
    output: str | Path,
    means: TypeMeans | None,
) -> None:
    """Write the propagation network with the means of training surfaces."""
    from plan2scene.propagation.model import save_propagation
    from plan2scene.propagation.network import PropagationNetwork

    if means is None:
        expected = "means over training surfaces with a propagation checkpoint"
        raise InputError(expected, "none", file=checkpoint)
    sizes = {"width": 96, "layers": 3}
    network = PropagationNetwork(sizes["width"], sizes["layers"])
    network.load_state_dict(fitted_state(state, _shapes(network), checkpoint))
    save_propagation(output, network, means, **sizes)


def _convert_classifier(
    state: dict[str, torch.Tensor], checkpoint: str | Path, output: str | Path, order: list[int]
) -> None:
    """Write the VGG-16 substance classifier, its last layer sorted to our order."""
    from plan2scene.metrics.vgg import VggClassifier

    with torch.device("meta"):
        shapes = _shapes(VggClassifier())
    fitted = fitted_state(state, shapes, checkpoint)
    for name in ("classifier.6.weight", "classifier.6.bias"):
        fitted[name] = fitted[name][order]
    save_model_file(output, fitted, {"network": "vgg16", "divisor": 1}, half=False)


def _convert_inception(
    state: dict[str, torch.Tensor], checkpoint: str | Path, output: str | Path
) -> None:
    """Write InceptionV3 without its classes, whose number says which variant it is."""
    from plan2scene.metrics.inception import VARIANTS, InceptionV3

    classes = next((len(v) for name, v in state.items() if name.endswith("fc.bias")), None)
    if classes not in VARIANTS:
        expected = f"fc.bias of {' or '.join(str(n) for n in VARIANTS)} classes"
        raise InputError(expected, str(classes or "none"), file=checkpoint)
    counter = "num_batches_tracked"  # of training
    with torch.device("meta"):
        shapes = _shapes(InceptionV3(VARIANTS[classes]))
    fitted = fitted_state(
        {name: value for name, value in state.items() if not name.endswith(counter)},
        {name: shape for name, shape in shapes.items() if not name.endswith(counter)},
        checkpoint,
        dropped=("fc.", "AuxLogits."),
    )
    architecture = {"network": "inception", "variant": VARIANTS[classes], "divisor": 1}
    save_model_file(output, fitted, architecture, half=False)
