"""Reading a checkpoint of ``torch.save``: tensors and plain values, never code (docs/rent3dpp.md).

A pickle can name any function to be called while it is read. torch's restricted reader refuses
every name that is not on its list of tensor types; nothing else reads these files here.
"""

from __future__ import annotations

import collections
import pickle
import re
import struct
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch

from plan2scene.errors import InputError

#: Where a checkpoint keeps its tensors: the authors' own files, then those of PyTorch Lightning.
STATE_KEYS = ("model_state_dict", "state_dict")
_SCALAR, _ARRAY = np.float64(0).__reduce__()[0], np.zeros(1).__reduce__()[0]
#: Types of losses that are stored beside the weights: numbers and arrays of NumPy, under both names
#: of its module, and dicts with a default. All of them hold data only.
_HARMLESS: list[Any] = [
    np.dtype,
    np.dtypes.Float32DType,
    np.dtypes.Float64DType,
    np.dtypes.Int64DType,
    np.ndarray,
    *((_SCALAR, f"numpy.{core}.multiarray.scalar") for core in ("core", "_core")),
    *((_ARRAY, f"numpy.{core}.multiarray._reconstruct") for core in ("core", "_core")),
    collections.defaultdict,
    list,
]
#: Errors that the restricted reader raises for a file that is no pickle, or a truncated one.
_DAMAGED = (
    RuntimeError,
    ValueError,
    LookupError,
    TypeError,
    AttributeError,
    AssertionError,
    EOFError,
    MemoryError,
    OSError,
    struct.error,
)
_GLOBAL = re.compile(r"GLOBAL ([\w.]+)|(?:class|function|global)\w* ([\w]+\.[\w.]+)", re.IGNORECASE)


def read_checkpoint(path: str | Path) -> Mapping[str, Any]:
    """Return the dict in a checkpoint, tensors on the CPU.

    Raises InputError if the file names code, is damaged or of another kind.
    """
    if not Path(path).is_file():
        raise InputError("a checkpoint", "no such file", file=path)
    try:
        with torch.serialization.safe_globals(_HARMLESS), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about odd pickles; errors are reported below
            document = torch.load(path, map_location="cpu", weights_only=True)
    except pickle.UnpicklingError as error:
        raise _refusal(path, str(error)) from None
    except _DAMAGED:
        found = "another or a damaged file"
        raise InputError("a checkpoint of torch.save", found, file=path) from None
    if not isinstance(document, Mapping):
        raise InputError("a dict in the checkpoint", type(document).__name__, file=path)
    return document


def _refusal(path: str | Path, message: str) -> InputError:
    """Return the error of a pickle that the restricted reader refuses."""
    match = _GLOBAL.search(message)
    expected = "a checkpoint of tensors and plain values"
    if match is None:
        return InputError(expected, "a pickle that torch's restricted reader refuses", file=path)
    name = match.group(1) or match.group(2)
    return InputError(expected, f"{name} in it, which is not run", file=path)


def state_dict_of(document: Mapping[str, Any], path: str | Path) -> dict[str, torch.Tensor]:
    """Return the tensors of a checkpoint by name: under :data:`STATE_KEYS`, or the dict itself."""
    state: Any = next((document[key] for key in STATE_KEYS if key in document), document)
    if not isinstance(state, Mapping):
        raise InputError("a dict of tensors", type(state).__name__, file=path)
    wrong = [str(name) for name, value in state.items() if not isinstance(value, torch.Tensor)]
    if wrong or not state:
        found = f"{', '.join(wrong[:5])} of other kinds" if wrong else "nothing"
        raise InputError(f"tensors, or a dict {' or '.join(STATE_KEYS)}", found, file=path)
    return {str(name): value for name, value in state.items()}


def fitted_state(
    state: Mapping[str, torch.Tensor],
    expected: Mapping[str, tuple[int, ...]],
    path: str | Path,
    *,
    dropped: tuple[str, ...] = (),
) -> dict[str, torch.Tensor]:
    """Return the tensors of :func:`state_dict_of` under our names, float32.

    All names of `state` may share a prefix (``module.``, ``model.`` ...). `expected` is the shape
    of every tensor of our network by name; `dropped` are prefixes of names that our network leaves
    out on purpose. Raises InputError for missing or unknown tensors (with their number), and for
    one of another shape or not finite.
    """
    prefix = _common_prefix(state, expected)
    named = {name.removeprefix(prefix): value for name, value in state.items()}
    unknown = [n for n in named if n not in expected and not n.startswith(dropped or ("\0",))]
    missing = [name for name in expected if name not in named]
    if missing:
        found = f"{len(missing)} of {len(expected)} tensors missing, {len(unknown)} unknown"
        raise InputError(f"tensor {missing[0]} {expected[missing[0]]}", found, file=path)
    if unknown:
        found = f"also {unknown[0]} ({len(unknown)} unknown)"
        raise InputError(f"the {len(expected)} tensors of the network", found, file=path)
    for name, shape in expected.items():
        if tuple(named[name].shape) != shape:
            found = str(tuple(named[name].shape))
            raise InputError(f"shape {shape} of tensor {name}", found, file=path)
    return {name: _plain(named[name], name, path) for name in expected}


def _plain(tensor: torch.Tensor, name: str, path: str | Path) -> torch.Tensor:
    """Return a tensor as float32; InputError if it is not a dense array of finite real numbers."""
    odd = tensor.is_complex() or tensor.is_quantized or tensor.is_meta
    if odd or tensor.layout is not torch.strided:
        kind = "meta" if tensor.is_meta else tensor.dtype
        found = f"{kind}, {tensor.layout}".replace("torch.", "")
        raise InputError(f"a dense tensor of real numbers {name}", found, file=path)
    values = tensor.detach().float()
    if not bool(torch.isfinite(values).all()):
        raise InputError(f"finite values in tensor {name}", "NaN or infinity", file=path)
    return values


def _common_prefix(state: Mapping[str, object], expected: Mapping[str, object]) -> str:
    """Return the prefix of all names of a network in a checkpoint; "" if there is none."""
    probe = max(expected, key=len)
    if probe in state:
        return ""
    prefixes = [name[: -len(probe)] for name in state if name.endswith("." + probe)]
    return prefixes[0] if prefixes else ""
