"""Labels by a pretrained ADE20K network (the paper's kind of segmentation).

Any semantic segmentation checkpoint of the transformers package with the 150 classes of ADE20K
works (SegFormer, UPerNet, BEiT ...): a local folder, or a pinned commit of the Hugging Face hub.
Weights are read from safetensors only, and no code of a checkpoint is ever run.
"""

from __future__ import annotations

import importlib
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import torch
from torch.nn import functional as F

from plan2scene.errors import InputError
from plan2scene.photos.labels.segmentation import network_size, to_tensor, upsampled_argmax

#: ADE20K class indices of floor, wall and ceiling, in the order of our labels 1, 2, 3. The other
#: 147 classes become label 0, other (docs/photos.md).
ADE20K_SURFACES = (3, 0, 5)
ADE20K_CLASSES = 150
#: Channel means and standard deviations of ImageNet, for checkpoints that come without their own.
_MEAN = (0.485, 0.456, 0.406)
_STD = (0.229, 0.224, 0.225)
#: Longer side of the network's input in pixels; ADE20K networks are trained at 512 and above.
LONG_SIDE = 640
_COMMIT = re.compile(r"[0-9a-f]{40}")
_HUB_ID = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*/[A-Za-z0-9][A-Za-z0-9_.-]*")


@dataclass(frozen=True)
class Checkpoint:
    """Where a pretrained network is: a folder, or a commit of the hub (``photos.pretrained.*``)."""

    path: str | None = None  #: local folder with config.json and weights in safetensors
    #: id, revision: ``owner/name`` on the hub, and the 40 hexadecimal digits of a commit. Branches
    #: and tags move, so they are refused.
    id: str | None = None
    revision: str | None = None

    def check(self) -> None:
        """Raise InputError unless the keys name exactly one folder or one pinned commit."""
        if bool(self.path) == bool(self.id):
            found = "both" if self.path else "neither"
            raise InputError("photos.pretrained.path or photos.pretrained.id", found)
        if self.path and self.revision:
            raise InputError("photos.pretrained.revision only with an id", "a path", file=self.path)
        if self.path and not (Path(self.path) / "config.json").is_file():
            expected = "a folder with an ADE20K checkpoint (config.json)"
            raise InputError(expected, "no such file", file=self.path)
        if self.id and not _HUB_ID.fullmatch(self.id):
            raise InputError("photos.pretrained.id as owner/name", self.id)
        if self.id and not _COMMIT.fullmatch(self.revision or ""):
            expected = "photos.pretrained.revision: a commit of 40 hexadecimal digits"
            raise InputError(expected, self.revision or "none", file=self.id)


class PretrainedSegmenter:
    """Labels photos by a transformers model with ADE20K classes.

    The model is called with ``pixel_values`` (1, 3, h, w) and returns ``logits`` (1, 150, h', w').
    `mean` and `std` are per channel, of sRGB values in [0, 1].
    """

    def __init__(
        self, model: Any, *, mean: Sequence[float] = _MEAN, std: Sequence[float] = _STD
    ) -> None:
        self.model = model.eval()
        self.mean, self.std = (torch.tensor(v).float().view(3, 1, 1) for v in (mean, std))

    @torch.inference_mode()
    def labels(self, image: np.ndarray) -> np.ndarray:
        """Return (h, w) uint8 labels (0 other, 1 floor, 2 wall, 3 ceiling) of a sRGB photo.

        The logit of other is the largest of the remaining classes, so doors, windows and rugs are
        other.
        """
        size = (image.shape[0], image.shape[1])
        height, width = network_size(size, LONG_SIDE)
        small = cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA)
        output = self.model(pixel_values=((to_tensor(small) - self.mean) / self.std)[None])
        logits = output.logits[0].float()
        rest = [k for k in range(ADE20K_CLASSES) if k not in ADE20K_SURFACES]
        four = torch.cat([logits[rest].amax(0, keepdim=True), logits[list(ADE20K_SURFACES)]])
        four = F.interpolate(four[None], size=(height // 2, width // 2), mode="bilinear")[0]
        return upsampled_argmax(np.ascontiguousarray(four.numpy()), size)


def load_pretrained(checkpoint: Checkpoint) -> PretrainedSegmenter:
    """Return the segmenter of a checkpoint.

    Raises InputError when :meth:`Checkpoint.check` does, when the transformers package (extra
    ``pretrained``) is missing, or when the checkpoint does not load from safetensors without code
    of its own, lacks weights, or has other classes than ADE20K's.
    """
    checkpoint.check()
    name = str(checkpoint.path or checkpoint.id)
    try:
        transformers = importlib.import_module("transformers")
        base = importlib.import_module("transformers.image_processing_base")
    except ImportError as error:
        expected = "the package transformers (install the extra 'pretrained')"
        raise InputError(expected, str(error), file=name) from None
    from safetensors import SafetensorError

    options: dict[str, Any] = {"revision": checkpoint.revision}
    if checkpoint.path:
        options = {"local_files_only": True}
    try:
        model, info = transformers.AutoModelForSemanticSegmentation.from_pretrained(
            name, use_safetensors=True, trust_remote_code=False, output_loading_info=True, **options
        )
    except (OSError, ValueError, KeyError, RuntimeError, SafetensorError) as error:
        raise InputError("a semantic segmentation checkpoint", str(error), file=name) from None
    missing = sorted(info["missing_keys"])
    if missing:  # transformers would fill them at random
        found = f"{len(missing)} missing, the first {missing[0]}"
        raise InputError("all weights of the network", found, file=name)
    _check_classes(model.config, name)
    try:
        values, _ = base.ImageProcessingMixin.get_image_processor_dict(name, **options)
    except OSError:  # a checkpoint without preprocessor_config.json
        values = {}
    return PretrainedSegmenter(
        model, mean=values.get("image_mean") or _MEAN, std=values.get("image_std") or _STD
    )


def _check_classes(config: Any, name: str) -> None:
    """Raise InputError unless a model has 150 classes; if they have names, in ADE20K's order."""
    if config.num_labels != ADE20K_CLASSES:
        raise InputError(f"{ADE20K_CLASSES} classes (ADE20K)", f"{config.num_labels}", file=name)
    for index, ours in zip(ADE20K_SURFACES, ("floor", "wall", "ceiling"), strict=True):
        theirs = str(config.id2label.get(index, "")).lower()
        if not theirs.startswith((ours, "label_")):
            expected = f"class {index} to be {ours}, as in ADE20K"
            raise InputError(expected, theirs or "no name", file=name)
