"""Weights and a crop given by formulas: what the parity figures of the references are for."""

from collections import OrderedDict

import numpy as np
import torch


def formula_state(module: torch.nn.Module) -> OrderedDict[str, torch.Tensor]:
    """Return tensors whose elements are an integer hash of their place in the sorted names."""
    mask, state = np.uint64(2**32 - 1), OrderedDict()
    for k, (name, value) in enumerate(sorted(module.state_dict().items())):
        shape = tuple(value.shape)
        h = (np.arange(int(np.prod(shape)), dtype=np.uint64) + np.uint64(1 + 1000003 * k)) & mask
        for _ in range(2):
            h = ((h ^ (h >> np.uint64(16))) * np.uint64(0x45D9F3B)) & mask
        h ^= h >> np.uint64(16)
        fan_in = np.prod(shape[1:]) if len(shape) > 1 else 1
        values = 2 * (h / 2**32 - 0.5) * np.sqrt(3 / fan_in) * (0.1 if len(shape) == 1 else 1.0)
        state[name] = torch.from_numpy(values.reshape(shape).astype(np.float32))
    return state


def formula_crop() -> np.ndarray:
    """Return a (128, 128, 3) uint8 crop of waves."""
    y, x = np.mgrid[:128, :128].astype(float)
    base = 0.5 + 0.25 * np.sin(2 * np.pi * (3 * x + 5 * np.sin(2 * np.pi * y / 128)) / 128)
    base += 0.1 * np.sin(2 * np.pi * 17 * y / 128)
    rgb = [0.9 * base, 0.7 * base + 0.02 * np.sin(x / 7), 0.5 * base + 0.03 * np.cos(y / 9)]
    return np.clip(np.rint(255 * np.stack(rgb, -1)), 0, 255).astype(np.uint8)
