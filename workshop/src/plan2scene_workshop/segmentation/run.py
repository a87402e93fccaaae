"""The training run of the segmentation network: labelled photos in, weights and a card out."""

from __future__ import annotations

import copy
import logging
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import torch
from torch import nn

from plan2scene.errors import InputError
from plan2scene.photos.labels.network import Ensemble, ImagenetSegmentationNet, SegmentationNet
from plan2scene.photos.labels.palette import LABELS, LABELS_AND_OPENINGS
from plan2scene.photos.labels.segmentation import SCALES, Network, load_segmenter
from plan2scene.provenance import file_hash
from plan2scene.seeds import derive_seed
from plan2scene.weights import fitting, save_model_file
from plan2scene_workshop.segmentation.calibration import best_temperature
from plan2scene_workshop.segmentation.data import (
    LabelledPhoto,
    Scores,
    read_labelled_photos,
    scores,
)
from plan2scene_workshop.segmentation.settings import SegmentationSettings
from plan2scene_workshop.segmentation.training import (
    answers,
    estimated_cameras,
    take_statistics,
    train_network,
)
from plan2scene_workshop.training.card import Card, table, write_card
from plan2scene_workshop.training.loop import Trained

_LOG = logging.getLogger("plan2scene")
_WHAT = """
Labels every pixel of a room photo as other, floor, wall, ceiling, door or window; furniture, rugs
and pictures are other. `plan2scene.photos.labels.network.SegmentationNet`, {:.2f} M
parameters, float16; photos are seen at {} pixels on their longer side.
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
    further = settings.further.split(":") if settings.further else []
    roots = [data_root, *further]
    # Photos are stored a little larger than views, so that a view that zooms in is not blurred.
    stored = round(settings.long_side * 1.5)
    photos = _photos([data_root], "train", stored)
    photos += [replace(photo, taught=False) for photo in _photos(further, "train", stored)]
    held_out = _photos(roots, "val", 1024)
    held_out = held_out[:: max(1, len(held_out) // settings.evaluate_photos)]
    photos, held_out = (_learned(those, amodal=settings.amodal) for those in (photos, held_out))
    _LOG.info("%d photos, %d held out", len(photos), len(held_out))
    trained = averaged_runs(photos, held_out, settings, seed=seed, checkpoint=checkpoint)
    network = _with(trained.network, settings.beside)
    save_model_file(model_path, network.state_dict(), network.architecture)
    shipped = load_segmenter(model_path).network
    found = list(answers(shipped, held_out, estimated_cameras(held_out)))
    final = scores([matrix for matrix, _ in found])
    truth = [photo.learned for photo in held_out]
    temperature = settings.temperature or best_temperature([part for _, part in found], truth)
    network.architecture["temperature"] = temperature
    save_model_file(model_path, network.state_dict(), network.architecture)
    seen = [f"{len(photos)} rendered photos of the synthetic train split.", "No real photo."]
    if settings.start:
        seen.append(
            f"Weights of {Path(settings.start).name} ({file_hash(settings.start)}) to start."
        )
    for file in settings.teachers.split(":") if settings.teachers else ():
        seen.append(f"The answers of {Path(file).name} ({file_hash(file)}), one of its teachers.")
    for file in settings.beside.split(":") if settings.beside else ():
        seen.append(f"Beside it, untouched: {Path(file).name} ({file_hash(file)}).")
    size = sum(parameter.numel() for parameter in shipped.parameters()) / 1e6
    rows = {name: [value] for name, value in zip(LABELS, final.iou, strict=True)}
    rows |= {"door or window": [final.openings]}
    rows |= {"**mean**": [final.mean_iou], "pixel accuracy": [final.accuracy]}
    figures = _FIGURES.format(len(held_out)) + table(["label", "IoU"], rows)
    sides = ", ".join(str(round(shipped.long_side * scale)) for scale in SCALES)
    what = _WHAT.format(size, sides)
    about = Card("segmentation", what, seen, settings, seed, figures)
    write_card(card_path, about, trained, model_path)
    return final


def averaged_runs(
    photos: Sequence[LabelledPhoto],
    held_out: Sequence[LabelledPhoto],
    settings: SegmentationSettings,
    *,
    seed: int,
    checkpoint: Path | None = None,
) -> Trained[SegmentationNet]:
    """Return the weighted mean of the runs' networks and of the network that they started from.

    The first run has `seed`, the others have seeds derived from it. Each run has its own
    checkpoint; all but `checkpoint` are deleted after the last run.
    """
    _check(settings)
    start = _begun(settings, seed)
    runs, files = [], [checkpoint]
    files += [checkpoint and Path(f"{checkpoint}{k}") for k in range(1, settings.runs)]
    for k, file in enumerate(files):
        run_seed = derive_seed(seed, "segmentation", "run", k) if k else seed
        network = copy.deepcopy(start)
        runs.append(
            train_network(network, photos, held_out, settings, seed=run_seed, checkpoint=file)
        )
    for file in files[1:]:
        if file:
            file.unlink(missing_ok=True)
    alone = settings.runs == 1 and not settings.start_share and not settings.statistics
    share = (1 - settings.start_share) / settings.runs
    states = [(settings.start_share, start.state_dict())]
    states += [(share, run.network.state_dict()) for run in runs]
    mean = runs[0].network
    mean.load_state_dict(mean_weights(states))
    if settings.statistics:
        take_statistics(mean, photos, settings, seed=seed)
    seconds = sum(run.seconds for run in runs)
    return Trained(mean, runs[0].step, runs[0].score if alone else math.nan, seconds)


def _check(settings: SegmentationSettings) -> None:
    """Raise InputError for settings out of their range."""
    runs, share = settings.runs, settings.start_share
    chances = settings.distillation, settings.mixing
    if runs >= 1 and 0 <= share < 1 and all(0 <= chance <= 1 for chance in chances):
        return
    found = f"{runs} runs, start_share {share}, distillation {chances[0]}, mixing {chances[1]}"
    section = "training.segmentation"
    raise InputError(
        f"{section}.runs from 1, start_share in [0, 1), distillation and mixing in [0, 1]", found
    )


def _begun(settings: SegmentationSettings, seed: int) -> SegmentationNet:
    """Return the network that all runs start from."""
    torch.manual_seed(derive_seed(seed, "segmentation", "weights"))
    if settings.imagenet:
        return _with_imagenet(settings)
    network = SegmentationNet(
        attention=settings.attention,
        long_side=settings.long_side,
        elevation=True,
        labels=len(LABELS_AND_OPENINGS),
        logit_adjustment=settings.logit_adjustment,
    )
    if settings.start:
        start_from(network, settings.start)
    return network


def _with_imagenet(settings: SegmentationSettings) -> ImagenetSegmentationNet:
    """Return a network with an ImageNet network and the weights of `settings.start`.

    If these weights have no ImageNet part, that part adds nothing yet.
    """
    expected = "training.segmentation.start: weights of an ensemble"
    if settings.start is None:
        raise InputError(expected, "null")
    ensemble = load_segmenter(settings.start).network
    if isinstance(ensemble, ImagenetSegmentationNet):
        return ensemble
    if not isinstance(ensemble, Ensemble) or not 0 <= settings.member < len(ensemble.members):
        raise InputError(f"{expected} of more than {settings.member} networks", settings.start)
    own = cast("SegmentationNet", ensemble.members[settings.member])
    network = ImagenetSegmentationNet(**own.architecture)
    network.load_state_dict(own.state_dict(), strict=False)
    return network


def mean_weights(states: Sequence[tuple[float, Mapping[str, torch.Tensor]]]) -> dict[str, Any]:
    """Return the weighted mean of state dicts of one architecture; integers are the last one's."""
    last = states[-1][1]
    return {
        name: sum(share * state[name] for share, state in states)
        if value.is_floating_point()
        else value
        for name, value in last.items()
    }


def _photos(roots: Sequence[str | Path], split: str, long_side: int) -> list[LabelledPhoto]:
    """Return the photos of a split of several data sets."""
    return [
        photo for root in roots for photo in read_labelled_photos(root, split, long_side=long_side)
    ]


def _learned(photos: Sequence[LabelledPhoto], *, amodal: bool) -> list[LabelledPhoto]:
    """Return photos without amodal labels, or with them, if these are learned.

    InputError if a photo has no `amodal` labels.
    """
    if not amodal:
        return [replace(photo, amodal=None) for photo in photos]
    if any(photo.amodal is None for photo in photos):
        raise InputError("photos with amodal labels (synthetic.snapshots.amodal)", "none")
    return list(photos)


def _with(network: SegmentationNet, files: str | None) -> Network:
    """Return the ensemble of a network and those of weights files (joined by ``:``), if any."""
    if not files:
        return network
    members: list[Network] = [network]
    for file in files.split(":"):
        members.append(load_segmenter(file).network)
        with fitting("a network of the trained one's shapes", file):
            ensemble_of([network, members[-1]])
    return ensemble_of(members)


def _mean_of(network: Network) -> Mapping[str, torch.Tensor]:
    """Return a network's weights; for an ensemble, the mean of its members' weights."""
    if isinstance(network, SegmentationNet):
        return network.state_dict()
    share = 1 / len(network.members)
    return mean_weights([(share, member.state_dict()) for member in network.members])


def start_from(network: SegmentationNet, path: str | Path) -> None:
    """Copy the weights of a file into a network where names and shapes agree.

    Of an ensemble, the mean of the members is copied. If the file's network does not know doors
    and windows, their weights start as copies of those of other.
    """
    own = network.state_dict()
    for name, value in _mean_of(load_segmenter(path).network).items():
        if name in own and own[name].shape == value.shape:
            own[name] = value
        elif name.startswith("head."):
            own[name] = torch.cat(
                [value, value[:1].expand(len(own[name]) - len(value), *value.shape[1:])]
            )
    network.load_state_dict(own)


def ensemble_of(networks: Sequence[nn.Module]) -> Ensemble:
    """Return the ensemble of networks; its architecture and constants are the first one's.

    RuntimeError if a network's shapes differ from the first one's.
    """
    architecture: dict[str, Any] = networks[0].architecture  # type: ignore[assignment]
    ensemble = Ensemble(members=len(networks), **architecture)
    for member, network in zip(ensemble.members, networks, strict=True):
        member.load_state_dict(network.state_dict())
    return ensemble
