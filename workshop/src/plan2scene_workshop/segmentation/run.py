"""The training run of the segmentation network: labelled photos in, weights and a card out."""

from __future__ import annotations

import logging
from pathlib import Path

import torch

from plan2scene.photos.labels.network import SegmentationNet
from plan2scene.photos.labels.palette import LABELS
from plan2scene.photos.labels.segmentation import load_segmenter
from plan2scene.seeds import derive_seed
from plan2scene.weights import save_model_file
from plan2scene_workshop.segmentation.data import Scores, read_labelled_photos
from plan2scene_workshop.segmentation.settings import SegmentationSettings
from plan2scene_workshop.segmentation.training import estimated_cameras, evaluate, train_network
from plan2scene_workshop.training.card import Card, table, write_card

_LOG = logging.getLogger("plan2scene")
_WHAT = """
Labels every pixel of a room photo as other, floor, wall or ceiling; doors, windows, furniture, rugs
and pictures are other. `plan2scene.photos.labels.segmentation.SegmentationNet`, {:.2f} M
parameters, float16; photos are scaled to {} pixels on their longer side, and to 1.4 times that.
"""
_FIGURES = """
Intersection over union on {} rendered photos of the val split (other houses), told the camera that
their line segments give:

"""


def train_segmentation(
    data_root: str | Path,
    model_path: str | Path,
    card_path: str | Path,
    *,
    settings: SegmentationSettings,
    seed: int,
    checkpoint: Path | None = None,
) -> Scores:
    """Train on the train split of a synthetic data set, write weights and card; return scores.

    The scores are those of the file as written (float16), on the val split.
    """
    # Stored a little larger than views, so that zooming in shows more than blur.
    photos = read_labelled_photos(data_root, "train", long_side=round(settings.long_side * 1.5))
    held_out = read_labelled_photos(data_root, "val", long_side=1024)
    every = max(1, len(held_out) // settings.evaluate_photos)
    _LOG.info("%d photos, %d held out", len(photos), len(held_out))
    torch.manual_seed(derive_seed(seed, "segmentation", "weights"))
    network = SegmentationNet(long_side=settings.long_side, elevation=True)
    trained = train_network(
        network, photos, held_out[::every], settings, seed=seed, checkpoint=checkpoint
    )
    network = trained.network
    save_model_file(model_path, network.state_dict(), network.architecture)
    shipped = load_segmenter(model_path).network
    final = evaluate(shipped, held_out, estimated_cameras(held_out))
    seen = [f"{len(photos)} rendered photos of the synthetic train split.", "No real photo."]
    size = sum(parameter.numel() for parameter in shipped.parameters()) / 1e6
    rows = {name: [value] for name, value in zip(LABELS, final.iou, strict=True)}
    rows |= {"**mean**": [final.mean_iou], "pixel accuracy": [final.accuracy]}
    figures = _FIGURES.format(len(held_out)) + table(["label", "IoU"], rows)
    what = _WHAT.format(size, shipped.long_side)
    about = Card("segmentation", what, seen, settings, seed, figures)
    write_card(card_path, about, trained, model_path)
    return final
