"""Seeds: every random choice depends on the global seed and the names of what it is for."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np


def derive_seed(seed: int, *names: object) -> int:
    """Return a 63-bit seed that depends on `seed` and `names` alone.

    It is the same on every platform and Python version (SHA-256, no ``hash()``), so the same
    (seed, house, room, surface) gives the same bytes.
    """
    text = "\x1f".join([str(int(seed)), *(str(name) for name in names)])
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "big") >> 1


def generator(seed: int, *names: object) -> np.random.Generator:
    """Return a numpy generator seeded by :func:`derive_seed`."""
    import numpy as np

    return np.random.default_rng(derive_seed(seed, *names))
