"""The masks stage: photos of one house -> label PNGs and camera estimates."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from plan2scene.errors import InputError
from plan2scene.io import atomic_directory, safe_join, write_json
from plan2scene.photos.camera.calibration import Camera, estimate_camera
from plan2scene.photos.camera.exif import ExifFocal, read_exif_focal
from plan2scene.photos.labels.palette import SOURCES, labels_from_folder, write_label_png
from plan2scene.photos.photo_files import read_photo

if TYPE_CHECKING:
    from plan2scene.photos.labels.pretrained import Checkpoint

_log = logging.getLogger("plan2scene")


@dataclass(frozen=True)
class Labeller:
    """What labels photos.

    Parameters
    ----------
    first : callable
        Given a photo's name and its (h, w, 3) pixels, returns its (h, w) labels.
    told : callable, optional
        Given the pixels and a camera that was found with the first labels, labels again.
    """

    first: Callable[[str, np.ndarray], np.ndarray]
    told: Callable[[np.ndarray, Camera], np.ndarray] | None = None


def labeller(
    source: str,
    *,
    model: str | Path | None = None,
    precomputed_dir: str | Path | None = None,
    pretrained: Checkpoint | None = None,
    threads: int = 1,
    house: str = "",
) -> Labeller:
    """Return what labels a photo, by source.

    Parameters
    ----------
    source : {"embedded", "precomputed", "pretrained"}
    model : path
        Embedded: the safetensors file.
    precomputed_dir : path
        Precomputed: the folder of ``{stem}.png``.
    pretrained : Checkpoint
        Pretrained: where the ADE20K network is.
    threads : int
        Processor threads of a network.

    Raises InputError when the source is unknown or what it needs is missing.
    """
    if source == "precomputed":
        if not precomputed_dir or not Path(precomputed_dir).is_dir():
            raise InputError(
                "a folder of label PNGs (photos.masks_folder)",
                f"no such folder {precomputed_dir or ''}".strip(),
                house=house,
            )
        folder = Path(precomputed_dir)
        return Labeller(
            lambda photo, image: labels_from_folder(
                folder, photo, (image.shape[0], image.shape[1]), house=house
            )
        )
    if source not in SOURCES:
        raise InputError(f"a mask source of {', '.join(SOURCES)}", source, house=house)
    if not (pretrained if source == "pretrained" else model):
        raise InputError(f"a model for mask source {source}", "none", house=house)
    import torch

    torch.set_num_threads(threads)
    if source == "pretrained" and pretrained:
        from plan2scene.photos.labels.pretrained import load_pretrained

        ade20k = load_pretrained(pretrained)
        return Labeller(lambda _photo, image: ade20k.labels(image))
    from plan2scene.photos.labels.segmentation import load_segmenter

    embedded = load_segmenter(str(model))
    return Labeller(
        lambda _photo, image: embedded.labels(image),
        embedded.labels if embedded.network.elevation else None,
    )


def make_masks(
    photos: Mapping[str, Path],
    out_dir: str | Path,
    *,
    house: str,
    source: str,
    fov_deg: float,
    model: str | Path | None = None,
    precomputed_dir: str | Path | None = None,
    pretrained: Checkpoint | None = None,
    threads: int = 1,
) -> list[str]:
    """Write the masks folder of a house and return its warnings.

    Parameters
    ----------
    photos : mapping of photo name to path
        A photo that is missing, damaged or tiny, has an unsafe name, or lacks its precomputed
        mask, becomes a warning and is left out; the house goes on without it. A focal length in
        its EXIF data that is not used becomes a warning too.
    out_dir : path
        Replaced as a whole: ``{stem}.png`` labels at the size that `read_photo` gives,
        ``cameras.json``, ``warnings.json`` (``docs/conventions.md``).
    fov_deg : float
        Horizontal field of view in degrees where neither EXIF data nor vanishing points give one.
    source, model, precomputed_dir, pretrained, threads
        As in :func:`labeller`.
    """
    _refuse_equal_stems(photos, house)
    cameras: dict[str, object] = {}
    warnings: list[str] = []
    with atomic_directory(out_dir) as folder:
        label: Labeller | None = None
        for name in sorted(photos):
            if label is None:  # a house without photos needs no network
                label = labeller(
                    source,
                    model=model,
                    precomputed_dir=precomputed_dir,
                    pretrained=pretrained,
                    threads=threads,
                    house=house,
                )
            try:
                safe_join("", name, house=house)
                image = read_photo(photos[name], house=house)
                labels = label.first(name, image)
            except InputError as error:
                _log.warning("photo %s left out: %s", name, error)
                warnings.append(f"photo {name} left out: {error}")
                continue
            exif = read_exif_focal(photos[name], (image.shape[0], image.shape[1]))
            camera = estimate_camera(image, labels, fov_deg=fov_deg, exif=exif)
            if label.told is not None and not camera.fallback:
                labels = label.told(image, camera)
                camera = estimate_camera(image, labels, fov_deg=fov_deg, exif=exif)
            write_label_png(folder / f"{Path(name).stem}.png", labels)
            cameras[name] = camera.to_json()
            warnings += [f"photo {name}: {line}" for line in _focal_warnings(camera, exif)]
        _log.info("%d photos labelled, %d left out", len(cameras), len(photos) - len(cameras))
        write_json(folder / "cameras.json", cameras)
        write_json(folder / "warnings.json", warnings)
    return warnings


def _focal_warnings(camera: Camera, exif: ExifFocal) -> list[str]:
    """Return why a focal length of EXIF data was not used, as lines; none where it was."""
    if exif.warning:
        return [exif.warning]
    if exif.focal_px is None or camera.focal_source == "exif":
        return []
    reason = "the photo is cropped" if exif.cropped else "vanishing points contradict it"
    return [
        f"EXIF focal length of {exif.focal_px:.0f} px not used, {reason} "
        f"({camera.focal_px:.0f} px, confidence {camera.confidence:.2f})"
    ]


def _refuse_equal_stems(photos: Mapping[str, Path], house: str) -> None:
    """Raise InputError when two photos of a house would share a mask file."""
    seen: dict[str, str] = {}
    for name in sorted(photos):
        other = seen.setdefault(Path(name).stem, name)
        if other != name:
            raise InputError(
                "photos of a house with different names before the extension",
                f"{other} and {name}",
                house=house,
            )
