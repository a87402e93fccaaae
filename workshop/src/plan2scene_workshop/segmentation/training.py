"""Training of the segmentation network: labelled photos in, weights and a model card out."""

from __future__ import annotations

import logging
import os
import platform
import time
from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import torch

from plan2scene.io import atomic_path
from plan2scene.photos.labels.palette import LABELS
from plan2scene.photos.labels.segmentation import SegmentationNet, load_segmenter
from plan2scene.weights import save_model_file
from plan2scene_workshop.segmentation.data import (
    Scores,
    gaze_of,
    read_labelled_photos,
    read_scenes,
    write_scenes,
)
from plan2scene_workshop.segmentation.loop import Settings, estimated_cameras, evaluate, train
from plan2scene_workshop.segmentation.scenes import random_scenes_and_eyes, scene_camera

_log = logging.getLogger("plan2scene")


def draw_scenes(output: str | Path, *, settings: Mapping[str, Any], seed: int) -> None:
    """Draw the drawn rooms that training uses beside photos and write them to a Parquet file."""
    chosen = Settings.of(settings)
    drawn = random_scenes_and_eyes(chosen.scenes, seed=seed, textures=chosen.textures)
    scenes = [replace(photo, gaze=gaze_of(scene_camera(eye))) for photo, eye in drawn]
    write_scenes(output, scenes, {"dataset": "training", "house": ""})


def train_start(
    scenes_path: str | Path,
    model_path: str | Path,
    *,
    settings: Mapping[str, Any],
    seed: int,
    threads: int,
) -> Scores:
    """Train on drawn rooms alone and write the weights that training on photos starts from.

    The scores are on a tenth of the rooms (at most 100), which training did not see.
    """
    torch.set_num_threads(threads)
    chosen = Settings.of(settings)
    scenes = read_scenes(scenes_path)
    count = min(100, max(1, len(scenes) // 10))
    network, found, _ = train(
        scenes[count:],
        scenes[:count],
        chosen,
        seed=seed,
        steps=chosen.scene_steps,
        learning_rate=chosen.learning_rate,
        sides=(chosen.scene_side, chosen.small),
    )
    save_model_file(model_path, network.state_dict(), network.architecture, half=False)
    return found


def train_segmentation(
    data_root: str | Path,
    scenes_path: str | Path,
    start_path: str | Path,
    model_path: str | Path,
    card_path: str | Path,
    *,
    settings: Mapping[str, Any],
    seed: int,
    threads: int,
) -> Scores:
    """Train on the train split of a synthetic data set, write weights and card; return scores.

    Starts from the weights of :func:`train_start`. The scores are
    those of the file as written (float16), on the val split.
    """
    torch.set_num_threads(threads)
    started = time.monotonic()
    chosen = Settings.of(settings)
    # Stored a little larger than views, so that zooming in shows more than blur.
    photos = read_labelled_photos(data_root, "train", long_side=round(chosen.long_side * 1.5))
    held_out = read_labelled_photos(data_root, "val", long_side=1024)
    every = max(1, len(held_out) // chosen.evaluate_photos)
    scenes = read_scenes(scenes_path)
    _log.info(
        "%d photos and %d scenes to train on, %d photos held out",
        len(photos),
        len(scenes),
        len(held_out),
    )
    network, _, step = train(
        photos,
        held_out[::every],
        chosen,
        seed=seed,
        steps=chosen.steps,
        learning_rate=chosen.photo_learning_rate,
        sides=(chosen.small, chosen.long_side),
        scenes=scenes,
        start=load_segmenter(start_path).network,
    )
    save_model_file(model_path, network.state_dict(), network.architecture)
    shipped = load_segmenter(model_path).network
    final = evaluate(shipped, held_out, estimated_cameras(held_out))
    counts = {"photos": len(photos), "held_out": len(held_out), "scenes": len(scenes)}
    card = model_card(
        shipped, final, chosen, counts, seed=seed, step=step, seconds=time.monotonic() - started
    )
    with atomic_path(card_path) as temporary:
        temporary.write_text(card, encoding="utf-8")
    return final


def model_card(
    network: SegmentationNet,
    found: Scores,
    settings: Settings,
    counts: Mapping[str, int],
    *,
    seed: int,
    step: int,
    seconds: float,
) -> str:
    """Return the model card as Markdown."""
    rows = "\n".join(f"| {n} | {v:.3f} |" for n, v in zip(LABELS, found.iou, strict=True))
    size = sum(p.numel() for p in network.parameters())
    device = torch.cuda.get_device_name() if torch.cuda.is_available() else platform.machine()
    used = ", ".join(f"{f.name} {getattr(settings, f.name)}" for f in fields(settings))
    return f"""# segmentation

Labels every pixel of a room photo as other, floor, wall or ceiling; doors, windows, furniture,
rugs and pictures are other. `plan2scene.photos.labels.segmentation.SegmentationNet`,
{size / 1e6:.2f} M parameters, float16; photos are scaled to {network.long_side} pixels on their
longer side.

- Data: {counts["photos"]} rendered photos of the synthetic train split and {counts["scenes"]}
  drawn rooms (`training.segmentation_scenes`); no real photo.
- Held out: {counts["held_out"]} rendered photos of the val split (other houses).
- Command: `snakemake train_segmentation`
- Seed {seed}; {used}.
- {settings.scene_steps} steps on drawn rooms alone (rule `segmentation_start`), then
  {settings.steps} with photos; the best of the validations was step {step} of these, which took
  {seconds / 60:.0f} minutes on {device}, {os.cpu_count()} cores, torch {torch.__version__}.

| label | IoU (held out) |
|---|---|
{rows}
| **mean** | **{found.mean_iou:.3f}** |

Pixel accuracy {found.accuracy:.3f}.
"""
