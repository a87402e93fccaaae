"""Weights on disk: safetensors with the architecture in the header. Never pickled code."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plan2scene.errors import InputError
from plan2scene.io import atomic_path
from plan2scene.provenance import WORKFLOW

if TYPE_CHECKING:
    import torch

#: Folder of the embedded weights.
MODELS = WORKFLOW / "resources" / "models"
_FORMAT = "plan2scene"


def save_model_file(
    path: str | Path,
    state: Mapping[str, torch.Tensor],
    architecture: Mapping[str, Any],
    *,
    half: bool = True,
) -> None:
    """Write a state dict atomically; floating tensors as float16 when `half`.

    `architecture` is what the model's constructor needs; it must be JSON.
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
    """Write the file's JSON header with sorted keys: the library's order differs run by run."""
    data = path.read_bytes()
    size = int.from_bytes(data[:8], "little")
    text = json.dumps(json.loads(data[8 : 8 + size]), sort_keys=True, separators=(",", ":"))
    header = text.encode()
    header += b" " * (-len(header) % 8)
    path.write_bytes(len(header).to_bytes(8, "little") + header + data[8 + size :])


def load_model_file(path: str | Path) -> tuple[dict[str, torch.Tensor], dict[str, Any]]:
    """Return (state dict with float32 tensors, architecture) of a file of :func:`save_model_file`.

    Raises InputError for a file that is missing, damaged or of another program.
    """
    state, architecture = _read(path, "pt", None)
    return {k: v.float() if v.is_floating_point() else v for k, v in state.items()}, architecture


def read_model_arrays(
    path: str | Path, names: Collection[str] | None = None
) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """As :func:`load_model_file`, as arrays and without torch; those of `names` alone if given."""
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
    except (SafetensorError, OSError) as error:
        raise InputError("a safetensors file", str(error), file=path) from None
    if metadata.get("format") != _FORMAT or "architecture" not in metadata:
        raise InputError("weights of this program", "no plan2scene header", file=path)
    return state, json.loads(metadata["architecture"])
