"""Label masks of photos on disk: palette PNG files.

Labels are 0 other, 1 floor, 2 wall, 3 ceiling; 255 is ignored (ground truth only). Doors and
windows are other, except in files that label them: 4 door, 5 window. This module does not import
torch, so that stages that only read masks stay light.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from plan2scene.errors import InputError
from plan2scene.images import decode_image
from plan2scene.io import atomic_path, safe_join
from plan2scene.photos.photo_files import reduced_size

if TYPE_CHECKING:
    from PIL import Image

#: Label names by value.
LABELS = ("other", "floor", "wall", "ceiling")
OTHER, FLOOR, WALL, CEILING, DOOR, WINDOW = range(6)
#: Label names by value in files that also label openings.
LABELS_AND_OPENINGS = (*LABELS, "door", "window")
IGNORE = 255
#: Uses that a photographed room may have.
KINDS = ("Reception", "Bedroom", "Kitchen", "Bathroom", "Corridor", "Closet")
#: Files of a masks folder: probabilities of `KINDS` for each photo; pairs of photos that see the
#: same things; pairs of photos from one spot; likeness of pairs of photos.
KINDS_FILE, TURNS_FILE, SPOTS_FILE = "kinds.json", "turns.json", "spots.json"
LIKENESS_FILE = "likeness.json"
#: Folders in a masks folder with the probability of each label: of what a photo shows, and of what
#: it would show without furniture (amodal).
PROBABILITIES, AMODAL = "probabilities", "amodal"
#: sRGB colour of each label in the palette PNG and in overlays.
PALETTE = (
    (128, 128, 128),
    (60, 180, 75),
    (70, 110, 220),
    (240, 200, 40),
    (200, 70, 60),
    (90, 220, 230),
)


def write_label_png(path: str | Path, labels: np.ndarray) -> None:
    """Write (h, w) uint8 labels as a palette PNG whose pixel values are the labels, atomically."""
    from PIL import Image

    image = Image.fromarray(np.ascontiguousarray(labels, dtype=np.uint8), mode="P")
    palette = [channel for colour in PALETTE for channel in colour]
    palette += [0] * (3 * 255 - len(palette)) + [0, 0, 0]
    image.putpalette(palette)
    with atomic_path(path) as temporary:
        image.save(temporary, format="PNG", optimize=False, compress_level=6)


def read_label_png(path: str | Path, *, house_id: str = "", openings: bool = False) -> np.ndarray:
    """Return (h, w) uint8 labels of a palette or grey PNG; without `openings` 4 and 5 become 0.

    Raises InputError for a file that is missing, no such image, or has a value that is no label.
    """
    labels = decode_image(path, _label_values, house_id=house_id)
    strange = sorted(set(np.unique(labels).tolist()) - {*range(len(LABELS_AND_OPENINGS)), IGNORE})
    if strange:
        raise InputError("labels 0 to 5 (or 255)", f"value {strange[0]}", file=path, house=house_id)
    return labels if openings else without_openings(labels)


def without_openings(labels: np.ndarray) -> np.ndarray:
    """Return labels (h, w) uint8 with doors and windows as other."""
    return np.where((labels == DOOR) | (labels == WINDOW), OTHER, labels).astype(np.uint8)


def _label_values(image: Image.Image) -> np.ndarray:
    """Return the (h, w) uint8 pixel values of a palette or grey image; its palette is ignored."""
    if image.mode not in ("P", "L"):
        raise InputError("a palette or grey PNG of labels", f"mode {image.mode}")
    return np.array(image, dtype=np.uint8)


def write_probability_png(path: str | Path, probabilities: np.ndarray) -> None:
    """Write (labels, h, w) float32 in [0, 1] as a grey PNG, one label below another, atomically."""
    from PIL import Image

    values = np.rint(255.0 * probabilities).astype(np.uint8)
    with atomic_path(path) as temporary:
        Image.fromarray(values.reshape(-1, values.shape[-1])).save(temporary, format="PNG")


def read_probability_png(path: str | Path, *, house_id: str = "") -> np.ndarray:
    """Return (6, h, w) float32 in [0, 1] of a PNG of `write_probability_png`.

    Raises InputError for a file that is missing or no such image.
    """
    values = decode_image(path, _label_values, house_id=house_id)
    labels = len(LABELS_AND_OPENINGS)
    if len(values) % labels:
        expected = f"rows of {labels} labels"
        raise InputError(expected, f"{len(values)} rows", file=path, house=house_id)
    return np.asarray(values.reshape(labels, -1, values.shape[1]) / 255.0, dtype=np.float32)


def labels_from_folder(
    folder: str | Path,
    photo: str,
    size: tuple[int, int],
    *,
    house_id: str = "",
    openings: bool = False,
) -> np.ndarray:
    """Return the labels of `photo` from a folder of ``{stem}.png`` (the precomputed source).

    The mask must have the `size` (height, width) that the photo has after
    :func:`~plan2scene.photos.photo_files.read_photo`, or the size before its reduction. Other sizes
    raise InputError, since the mask may be turned or cropped. With `openings` the labels 4 (door)
    and 5 (window) are kept; else they become 0. Pixels marked 255 become 0 (other).
    """
    path = safe_join(folder, f"{Path(photo).stem}.png", house_id=house_id)
    labels = read_label_png(path, house_id=house_id, openings=openings)
    mask_size = (labels.shape[0], labels.shape[1])
    if reduced_size(mask_size) != tuple(size):
        expected = f"a mask of the photo's size {size[1]}x{size[0]}"
        raise InputError(expected, f"{mask_size[1]}x{mask_size[0]}", file=path, house=house_id)
    if mask_size != tuple(size):
        rows, columns = (
            np.minimum((np.arange(new) + 0.5) * old / new, old - 1).astype(int)
            for new, old in zip(size, mask_size, strict=True)
        )
        labels = labels[np.ix_(rows, columns)]
    return np.where(labels == IGNORE, OTHER, labels).astype(np.uint8)
