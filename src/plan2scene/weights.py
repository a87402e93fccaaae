"""Weights on disk: safetensors with the architecture in the header. Never pickled code."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from plan2scene.errors import InputError
from plan2scene.io import atomic_path
from plan2scene.provenance import WORKFLOW

if TYPE_CHECKING:
    import torch
    from torch import nn

_Network = TypeVar("_Network", bound="nn.Module")
#: Folder of the embedded weights.
MODELS = WORKFLOW / "resources" / "models"
_FORMAT = "plan2scene"
#: Largest number, and largest length of a list or text, in the architecture in a file's header.
_MAX_SIZE = 4096
#: Errors that a wrong header or wrong tensors may cause while a network is built or filled.
_UNFIT = (RuntimeError, TypeError, ValueError, LookupError, ArithmeticError, AttributeError)


def save_model_file(
    path: str | Path,
    state: Mapping[str, torch.Tensor],
    architecture: Mapping[str, Any],
    *,
    half: bool = True,
) -> None:
    """Write a state dict atomically; floating-point tensors as float16 if `half`.

    `architecture` has the arguments of the model's constructor; it must be JSON.
    """
    from safetensors.torch import save_file

    tensors = {
        name: (value.half() if half and value.is_floating_point() else value)
        .detach()
        .cpu()
        .contiguous()
        for name, value in state.items()
    }
    header = {"format": _FORMAT, "architecture": json.dumps(dict(architecture), sort_keys=True)}
    with atomic_path(path) as temporary:
        save_file(tensors, temporary, metadata=header)
        _sort_header(temporary)


def _sort_header(path: Path) -> None:
    """Sort the keys of the file's JSON header: the library's order differs from run to run."""
    data = path.read_bytes()
    size = int.from_bytes(data[:8], "little")
    text = json.dumps(json.loads(data[8 : 8 + size]), sort_keys=True, separators=(",", ":"))
    header = text.encode()
    header += b" " * (-len(header) % 8)
    path.write_bytes(len(header).to_bytes(8, "little") + header + data[8 + size :])


def load_model_file(path: str | Path) -> tuple[dict[str, torch.Tensor], dict[str, Any]]:
    """Return (state dict with float32 tensors, architecture) of a file of :func:`save_model_file`.

    Raises InputError if the file is missing, damaged or from another program.
    """
    state, architecture = _read(path, "pt", None)
    return {k: v.float() if v.is_floating_point() else v for k, v in state.items()}, architecture


def read_model_arrays(
    path: str | Path, names: Collection[str] | None = None
) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Read a file like :func:`load_model_file`, but as NumPy arrays; only `names` if given."""
    state, architecture = _read(path, "np", names)
    floats = (np.float16, np.float64)
    return {
        k: v.astype(np.float32) if v.dtype in floats else v for k, v in state.items()
    }, architecture


def _read(
    path: str | Path, framework: str, names: Collection[str] | None
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return a file's tensors and architecture."""
    from safetensors import SafetensorError, safe_open

    try:
        with safe_open(path, framework=framework) as file:
            metadata = file.metadata() or {}
            wanted = [name for name in file.keys() if names is None or name in names]  # noqa: SIM118
            state = {name: file.get_tensor(name) for name in wanted}
    except (SafetensorError, OSError, ValueError, TypeError, AttributeError) as error:
        raise InputError("a safetensors file", str(error), file=path) from None
    if metadata.get("format") != _FORMAT or "architecture" not in metadata:
        raise InputError("weights of this program", "no plan2scene header", file=path)
    _check_tensors(state, path)
    return state, _architecture(metadata["architecture"], path)


def _check_tensors(state: Mapping[str, Any], path: str | Path) -> None:
    """Raise InputError for a tensor (of torch or NumPy) that is complex or not finite."""
    for name, tensor in state.items():
        values = tensor
        if not isinstance(tensor, np.ndarray) and not tensor.is_complex():
            values = (tensor.float() if tensor.is_floating_point() else tensor).numpy()
        if not isinstance(values, np.ndarray) or values.dtype.kind not in "fiub":
            raise InputError(f"numbers in tensor {name}", str(tensor.dtype), file=path)
        if not np.isfinite(values).all():
            raise InputError(f"finite values in tensor {name}", "NaN or infinity", file=path)


def _architecture(text: str, path: str | Path) -> dict[str, Any]:
    """Return the architecture in a header; InputError if no network of ours can have it."""
    fault = "an architecture with names and small numbers"
    try:
        architecture = json.loads(text)
    except (ValueError, RecursionError):
        raise InputError(fault, text[:60], file=path) from None
    if not isinstance(architecture, dict) or not all(map(_is_small, architecture.values())):
        raise InputError(fault, text[:60], file=path)
    return architecture


def _is_small(value: object) -> bool:
    """Return whether a JSON value is small enough for the architecture of a network."""
    if isinstance(value, list):
        return len(value) <= _MAX_SIZE and all(_is_small(item) for item in value)
    if isinstance(value, str):
        return len(value) <= _MAX_SIZE
    return value is None or (isinstance(value, int | float) and abs(value) <= _MAX_SIZE)


@contextmanager
def fitting(network: str, path: str | Path) -> Iterator[None]:
    """Turn errors that a wrong header or wrong tensors cause in the block into an InputError."""
    try:
        yield
    except InputError:
        raise
    except _UNFIT as error:
        found = " ".join(str(error).split("\n\t")[:2]) or type(error).__name__
        raise InputError(f"weights of {network}", found, file=path) from None


def filled(
    build: Callable[[], _Network], state: Mapping[str, torch.Tensor], name: str, path: str | Path
) -> _Network:
    """Return the network that `build` makes, with the tensors of a file, in evaluation mode.

    Names and shapes are compared before memory is allocated; InputError if they do not fit.
    """
    import torch

    with fitting(name, path):
        with torch.device("meta"):
            shapes = {key: value.shape for key, value in build().state_dict().items()}
        for key in [*shapes, *state]:
            if key not in shapes or key not in state or shapes[key] != state[key].shape:
                wanted = tuple(shapes[key]) if key in shapes else "no such tensor"
                found = tuple(state[key].shape) if key in state else "none"
                raise ValueError(f"{found} for tensor {key}, which is {wanted}")
        network = build()
        network.load_state_dict(dict(state))
    return network.eval()
