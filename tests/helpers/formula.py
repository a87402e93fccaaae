"""Weights and a crop given by formulas: what the parity figures of the references are for."""

from collections import OrderedDict

import numpy as np
import torch

from plan2scene.textures.model.texture_model import Architecture, TextureModel

# Figures that the reference implementation returns for weights and a crop given by formulas.
EMBEDDING = [1.2627286911010742, 1.3801169395446777, 0.44629013538360596, 0.5725345611572266]
EMBEDDING += [2.2141711711883545, -0.543013334274292, -0.24174371361732483, -0.09874101728200912]
EMBEDDING += [0.45098039507865906, 0.3482721745967865, 0.2519800364971161]
LOGITS = [0.8494102358818054, -0.22475911676883698, -0.7282568216323853, -0.5147141814231873]


def formula_state(module):
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


def formula_model():
    model = TextureModel(Architecture(periodic=False))
    model.load_state_dict(formula_state(model))
    return model.eval()


def formula_crop():
    y, x = np.mgrid[:128, :128].astype(float)
    base = 0.5 + 0.25 * np.sin(2 * np.pi * (3 * x + 5 * np.sin(2 * np.pi * y / 128)) / 128)
    base += 0.1 * np.sin(2 * np.pi * 17 * y / 128)
    rgb = [0.9 * base, 0.7 * base + 0.02 * np.sin(x / 7), 0.5 * base + 0.03 * np.cos(y / 9)]
    return np.clip(np.rint(255 * np.stack(rgb, -1)), 0, 255).astype(np.uint8)
