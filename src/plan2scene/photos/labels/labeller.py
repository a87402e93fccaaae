"""Sources of labels: the embedded network, a pretrained network, or a folder of masks."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np

from plan2scene.camera import Camera
from plan2scene.errors import InputError
from plan2scene.photos.camera.calibration import DEFAULT_FOV_DEG, estimate_camera
from plan2scene.photos.camera.exif import ExifFocal
from plan2scene.photos.camera.lines import PhotoSegments
from plan2scene.photos.labels.palette import (
    LABELS_AND_OPENINGS,
    labels_from_folder,
)

if TYPE_CHECKING:
    from plan2scene.photos.labels.network import SegmentationNet

#: Names of the sources of masks (config key ``photos.masks``).
SOURCES = ("embedded", "imagenet", "precomputed", "pretrained")


@dataclass(frozen=True, eq=False)
class Labelled:
    """The labels of a photo."""

    labels: np.ndarray  #: (h, w) uint8, the photo's size
    #: (6, h', w') float32 in [0, 1], of lower resolution: the probability of each label, doors and
    #: windows included; None from a source that does not give these.
    probabilities: np.ndarray | None = None
    #: The same for what the photo would show without furniture (amodal); None if unknown.
    amodal: np.ndarray | None = None


@dataclass(frozen=True)
class Labeller:
    """Functions that label photos; None for what the source cannot tell."""

    #: (a photo's name, its (h, w, 3) uint8 sRGB pixels, its camera or None) -> labels.
    label: Callable[[str, np.ndarray, Camera | None], Labelled]
    #: Pixels -> labels 0 to 3 from which the camera is estimated; None if the labels do not depend
    #: on the camera.
    draft: Callable[[np.ndarray], np.ndarray] | None = None
    #: Pixels -> probability of each of `palette.KINDS`, (k,).
    kinds: Callable[[np.ndarray], np.ndarray] | None = None
    #: Pixels -> whether the photo looks taken from outside.
    outside: Callable[[np.ndarray], bool] | None = None
    #: Pixels -> features (f,) float32 that are similar for photos of one room.
    look: Callable[[np.ndarray], np.ndarray] | None = None

    def labelled(
        self,
        photo: str,
        image: np.ndarray,
        *,
        fov_deg: float = DEFAULT_FOV_DEG,
        exif: ExifFocal | None = None,
        segments: PhotoSegments | None = None,
    ) -> Labelled:
        """Return the labels of a photo.

        Where they depend on the camera, it is estimated from draft labels. `fov_deg`, `exif` and
        `segments` are those of :func:`plan2scene.photos.camera.calibration.estimate_camera`.
        """
        if self.draft is None:
            return self.label(photo, image, None)
        camera = estimate_camera(
            image, self.draft(image), fov_deg=fov_deg, exif=exif, segments=segments
        )
        return self.label(photo, image, None if camera.fallback else camera)


def labeller(
    source: str,
    *,
    model: str | Path | None = None,
    imagenet: str | Path | None = None,
    kinds: str | Path | None = None,
    amodal: str | Path | None = None,
    things: bool = False,
    precomputed_dir: str | Path | None = None,
    pretrained: Mapping[str, str | None] | None = None,
    openings: bool = False,
    threads: int | None = None,
    house_id: str = "",
) -> Labeller:
    """Return the labeller of a source, one of :data:`SOURCES`.

    ``embedded`` needs the safetensors file `model`. `kinds` is the file of the classifier of rooms,
    which reads the maps of that network, `amodal` that of the network of amodal labels.
    ``imagenet`` also needs the file `imagenet` of a network that is averaged with those of `model`
    (extra ``rooms``). ``precomputed`` needs the folder of ``{stem}.png``; ``pretrained`` the fields
    of `pretrained.Checkpoint`. With `things` (for any source) the things in a room also show its
    use (extra ``rooms``). With `openings` doors are labelled 4 and windows 5 if the source labels
    them; else they are other. `threads` is the number of threads of a network; torch chooses it by
    default.

    Raises InputError when the source is unknown or something that it needs is missing.
    """
    if source not in SOURCES:
        raise InputError(f"a mask source of {', '.join(SOURCES)}", source, house=house_id)
    needed = {"imagenet": model and imagenet, "pretrained": pretrained}.get(source, model)
    if source != "precomputed" and not needed:
        raise InputError(f"a model for mask source {source}", "none", house=house_id)
    if threads is not None and (things or source != "precomputed"):
        import torch

        torch.set_num_threads(threads)
    if source == "precomputed":
        found = _precomputed(precomputed_dir, openings, house_id)
    elif source == "pretrained" and pretrained:
        from plan2scene.photos.labels.pretrained import Checkpoint, load_pretrained

        ade20k = load_pretrained(Checkpoint(**pretrained))
        found = Labeller(lambda _photo, image, _camera: Labelled(ade20k.labels(image)))
    else:
        imagenet = imagenet if source == "imagenet" else None
        found = _embedded(str(model), imagenet, kinds, amodal, openings)
    return _by_things(found) if things else found


def _by_things(other: Labeller) -> Labeller:
    """Return `other` with kinds by the things in a photo, times its own kinds if it has any."""
    from plan2scene.photos.labels.imagenet import load_imagenet
    from plan2scene.photos.labels.things import ThingKinds

    things = ThingKinds(load_imagenet())

    def joined(image: np.ndarray) -> np.ndarray:
        odds = things.probabilities(image) * (1.0 if other.kinds is None else other.kinds(image))
        return np.asarray(odds / odds.sum())

    return replace(other, kinds=joined, look=things.look, outside=things.outside)


def _embedded(
    model: str,
    imagenet: str | Path | None,
    kinds: str | Path | None,
    amodal: str | Path | None,
    openings: bool,
) -> Labeller:
    """Return the labeller of the networks of `model` and, if given, `imagenet`.

    The classifier `kinds` finds the use of rooms from the networks of `model` alone; `amodal` finds
    what is behind the furniture.
    """
    from plan2scene.photos.labels.kinds import load_kinds
    from plan2scene.photos.labels.segmentation import (
        AMODAL_SCALES,
        Segmenter,
        labels_of,
        load_segmenter,
        probabilities_of,
    )

    own = segmenter = load_segmenter(model)
    if imagenet:
        further = cast("SegmentationNet", load_segmenter(imagenet).network)
        segmenter = Segmenter(own.network, further)
    behind = load_segmenter(amodal) if amodal else None

    def label(_photo: str, image: np.ndarray, camera: Camera | None) -> Labelled:
        logits = segmenter.logits(image, camera)
        size, opened = (image.shape[0], image.shape[1]), segmenter.opened(logits)
        labels = labels_of(opened if openings else logits, size, openings=openings)
        if len(logits) != len(LABELS_AND_OPENINGS):
            return Labelled(labels)
        unfurnished = None
        if behind:
            unfurnished = probabilities_of(behind.logits(image, camera, AMODAL_SCALES))
        return Labelled(labels, probabilities_of(opened), unfurnished)

    tell = load_kinds(kinds, own) if kinds else None
    return Labeller(label, segmenter.draft if segmenter.network.elevation else None, tell)


def _precomputed(folder: str | Path | None, openings: bool, house_id: str) -> Labeller:
    """Return the labeller that reads labels from a folder."""
    if not folder or not Path(folder).is_dir():
        found = f"no such folder {folder or ''}".strip()
        raise InputError("a folder of label PNGs (photos.masks_folder)", found, house=house_id)
    ready = Path(folder)
    return Labeller(
        lambda photo, image, _camera: Labelled(
            labels_from_folder(
                ready,
                photo,
                (image.shape[0], image.shape[1]),
                house_id=house_id,
                openings=openings,
            )
        )
    )
