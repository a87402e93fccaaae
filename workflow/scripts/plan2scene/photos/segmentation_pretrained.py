"""Labels by a pretrained ADE20K network from a local folder (the paper's kind of segmentation).

Any semantic segmentation checkpoint of the transformers package with the 150 classes of ADE20K
will do (SegFormer, UPerNet, BEiT ...). Nothing is downloaded.
"""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import torch
from torch.nn import functional as F

from plan2scene.errors import InputError
from plan2scene.photos.segmentation import network_size, to_tensor, upsampled_argmax

#: ADE20K class indices of floor, wall and ceiling, in the order of our labels 1, 2, 3.
ADE20K_SURFACES = (3, 0, 5)
ADE20K_CLASSES = 150
#: Channel means and standard deviations of ImageNet, which these networks were trained with.
_MEAN = (0.485, 0.456, 0.406)
_STD = (0.229, 0.224, 0.225)
#: Longer side of the network's input in pixels; ADE20K networks are trained at 512 and above.
LONG_SIDE = 640


class PretrainedSegmenter:
    """Labels photos by a transformers model with ADE20K classes."""

    def __init__(self, model: Any) -> None:
        self.model = model.eval()

    @torch.inference_mode()
    def labels(self, image: np.ndarray) -> np.ndarray:
        """Return (h, w) uint8 labels (0 other, 1 floor, 2 wall, 3 ceiling) of a sRGB photo.

        Other is the best of all remaining classes, so doors, windows and rugs stay other.
        """
        size = (image.shape[0], image.shape[1])
        height, width = network_size(size, LONG_SIDE)
        small = cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA)
        mean, std = (torch.tensor(v).view(3, 1, 1) for v in (_MEAN, _STD))
        output = self.model(pixel_values=((to_tensor(small) - mean) / std)[None])
        logits = output.logits[0].float()
        rest = [k for k in range(ADE20K_CLASSES) if k not in ADE20K_SURFACES]
        four = torch.cat([logits[rest].amax(0, keepdim=True), logits[list(ADE20K_SURFACES)]])
        four = F.interpolate(four[None], size=(height // 2, width // 2), mode="bilinear")[0]
        return upsampled_argmax(np.ascontiguousarray(four.numpy()), size)


def load_pretrained(folder: str | Path) -> PretrainedSegmenter:
    """Return the segmenter of a local checkpoint folder (config.json and weights).

    Raises InputError when the folder or the transformers package (extra ``pretrained``) is
    missing, when the checkpoint does not load, or when it has other classes than ADE20K's.
    """
    path = Path(folder)
    if not (path / "config.json").is_file():
        raise InputError(
            "a folder with an ADE20K checkpoint (config.json)", "no such file", file=path
        )
    try:
        transformers = importlib.import_module("transformers")
    except ImportError as error:
        raise InputError(
            "the package transformers (install the extra 'pretrained')", str(error), file=path
        ) from None
    try:
        model = transformers.AutoModelForSemanticSegmentation.from_pretrained(
            path, local_files_only=True, use_safetensors=True, trust_remote_code=False
        )
    except (OSError, ValueError, KeyError, RuntimeError) as error:
        raise InputError("a semantic segmentation checkpoint", str(error), file=path) from None
    if model.config.num_labels != ADE20K_CLASSES:
        raise InputError(
            f"{ADE20K_CLASSES} classes (ADE20K)", f"{model.config.num_labels}", file=path
        )
    return PretrainedSegmenter(model)
