"""Training of the embedded features network: substance of badly photographed materials."""

from __future__ import annotations

import logging
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import cv2
import numpy as np
import torch
from torch.nn import functional

from plan2scene.house import SUBSTANCES
from plan2scene.io import atomic_path
from plan2scene.metrics.features import (
    FeaturesNetwork,
    extract_features,
    load_features_network,
)
from plan2scene.seeds import derive_seed, generator
from plan2scene.weights import load_model_file
from plan2scene_workshop.features.network import (
    SubstanceNetwork,
    as_tensor,
    save_features_network,
)
from plan2scene_workshop.texture.data import (
    CROP_PX,
    TextureSet,
    join_sets,
    procedural_textures,
    random_crop,
    sampling_weights,
    scanned_textures,
)

_LOGGER = logging.getLogger("plan2scene")
_LINE = np.linspace(-1.0, 1.0, CROP_PX, dtype=np.float32)


@dataclass(frozen=True)
class FeaturesTraining:
    """Settings of the training.

    Attributes
    ----------
    procedural : int
        Procedural materials to learn from; a fifth as many of other seeds are held out.
    texture_folder : str, optional
        Real tileable textures (a folder per substance, index.csv with splits); train is learnt
        from, val is held out.
    scanned_share : float
        Share of crops that come from that folder.
    steps, batch : int
        Updates, and crops in each.
    learning_rate, weight_decay : float
        AdamW; the rate rises for 5 % of the steps, then falls along a cosine to 0.
    minutes : float
        The schedule is shortened to end after this wall time.
    held_out_crops : int
        Crops of each held-out set that the card's figures come from, and training crops that the
        features are standardised over.
    start : str, optional
        Weights of an earlier training to go on from.
    seed : int
    """

    procedural: int = 1600
    texture_folder: str | None = None
    scanned_share: float = 0.4
    steps: int = 4000
    batch: int = 32
    learning_rate: float = 3e-3
    weight_decay: float = 1e-2
    minutes: float = 30.0
    held_out_crops: int = 1000
    start: str | None = None
    seed: int = 0


def _smooth_field(rng: np.random.Generator) -> np.ndarray:
    """Return a smooth random field (128, 128) float32 of about unit range."""
    coarse = rng.normal(0.0, 0.5, (4, 4)).astype(np.float32)
    return cv2.resize(coarse, (CROP_PX, CROP_PX), interpolation=cv2.INTER_CUBIC)


def photograph(crop: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return a crop as a photo of a room shows it.

    Uneven light, sometimes a shadow's edge or a highlight, white balance, lost resolution, noise
    and JPEG; each drawn anew.

    Parameters
    ----------
    crop : (128, 128, 3) uint8
        sRGB.
    """
    image = crop.astype(np.float32)
    gain = np.exp(rng.uniform(0.0, 0.25) * _smooth_field(rng) + rng.normal(0.0, 0.12))
    if rng.random() < 0.3:
        angle, offset = rng.uniform(0, 2 * np.pi), rng.uniform(-0.7, 0.7)
        side = np.cos(angle) * _LINE[None, :] + np.sin(angle) * _LINE[:, None] - offset
        gain *= 1.0 - rng.uniform(0.1, 0.45) / (1.0 + np.exp(-side / rng.uniform(0.03, 0.3)))
    image *= gain[..., None] * (1.0 + rng.normal(0.0, 0.05, 3).astype(np.float32))
    if rng.random() < 0.15:
        x, y = rng.uniform(-1, 1, 2)
        distance = (_LINE[None, :] - x) ** 2 + (_LINE[:, None] - y) ** 2
        blob = np.exp(-distance / rng.uniform(0.03, 0.3))[..., None]
        image += (255.0 - image) * blob * rng.uniform(0.2, 0.8)
    if rng.random() < 0.6:  # a distant surface: few photo pixels for the crop
        small = int(rng.uniform(0.25, 1.0) * CROP_PX)
        shrunk = cv2.resize(image, (small, small), interpolation=cv2.INTER_AREA)
        image = cv2.resize(shrunk, (CROP_PX, CROP_PX), interpolation=cv2.INTER_CUBIC)
    image += rng.normal(0.0, rng.uniform(0.0, 4.0), image.shape)
    result = np.rint(np.clip(image, 0, 255)).astype(np.uint8)
    if rng.random() < 0.7:
        quality = int(rng.integers(40, 95))
        encoded = cv2.imencode(".jpg", result, [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
        result = np.asarray(cv2.imdecode(encoded, cv2.IMREAD_COLOR), dtype=np.uint8)
    return result


def draw_crops(
    textures: TextureSet,
    weights: np.ndarray,
    count: int,
    rng: np.random.Generator,
    degraded_share: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Return crops (n, 128, 128, 3) uint8 and substances (n,) int64."""
    chosen = rng.choice(len(textures), size=count, p=weights)
    crops = []
    for index in chosen:
        closest = 160 if textures.scanned[index] else 96
        crop = random_crop(textures.tiles[index], rng, closest_px=closest)
        crops.append(photograph(crop, rng) if rng.random() < degraded_share else crop)
    return np.stack(crops), textures.substances[chosen]


def _rate(progress: float) -> float:
    """Return the share of the learning rate at `progress` in [0, 1]."""
    return min(progress / 0.05, 0.5 + 0.5 * float(np.cos(np.pi * min(progress, 1.0))))


def fit(
    network: SubstanceNetwork, textures: TextureSet, settings: FeaturesTraining
) -> tuple[int, float]:
    """Train in place; return the steps done and the minutes taken."""
    rng = generator(settings.seed, "features training")
    weights = sampling_weights(textures, settings.scanned_share)
    optimiser = torch.optim.AdamW(
        network.parameters(), settings.learning_rate, weight_decay=settings.weight_decay
    )
    network.train()
    start, step, progress = time.monotonic(), 0, 0.0
    mean_loss = 0.0
    while progress < 1.0:
        for group in optimiser.param_groups:
            group["lr"] = settings.learning_rate * _rate(progress)
        crops, substances = draw_crops(textures, weights, settings.batch, rng, 0.75)
        _, logits = network(as_tensor(crops))
        loss = functional.cross_entropy(logits, torch.from_numpy(substances), label_smoothing=0.05)
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        step += 1
        minutes = (time.monotonic() - start) / 60
        progress = max(step / settings.steps, minutes / settings.minutes)
        mean_loss += (float(loss.detach()) - mean_loss) / min(step, 100)
        if step % 200 == 0:
            _LOGGER.info("step %d, %.1f min, loss %.3f", step, minutes, mean_loss)
    return step, (time.monotonic() - start) / 60


def standardise(network: SubstanceNetwork, crops: np.ndarray) -> None:
    """Set the features' shift and scale to the mean and spread over `crops` (n, 128, 128, 3)."""
    network.eval()
    with torch.inference_mode():
        hidden = torch.cat(
            [
                network.hidden(as_tensor(part))
                for part in np.array_split(crops, max(1, len(crops) // 64))
            ]
        )
    # A feature that (almost) never fires would be blown up by its tiny spread.
    spread = hidden.std(dim=0)
    network.shift.copy_(hidden.mean(dim=0))
    network.scale.copy_(torch.maximum(spread, 0.1 * spread.mean()))


def confusion(
    network: FeaturesNetwork, textures: TextureSet, count: int, seed: int, degraded: bool
) -> np.ndarray:
    """Return the (4, 4) counts of true (row) against predicted substance over `count` crops."""
    rng = generator(seed, "features held out", degraded)
    weights = sampling_weights(textures, 1.0 if textures.scanned.all() else 0.0)
    crops, substances = draw_crops(textures, weights, count, rng, float(degraded))
    _, predicted = extract_features(network, list(crops))
    size = len(SUBSTANCES)
    return np.bincount(substances * size + predicted, minlength=size * size).reshape(size, size)


def _lines(name: str, counts: np.ndarray) -> list[str]:
    """Return one row of the card's table."""
    accuracy = np.trace(counts) / counts.sum()
    recalls = counts.diagonal() / np.maximum(counts.sum(axis=1), 1)
    cells = " | ".join(f"{r:.3f}" for r in recalls)
    return [f"| {name} | {counts.sum()} | {accuracy:.3f} | {cells} |"]


def train_features(
    model: str | Path, card: str | Path, *, settings: FeaturesTraining, cache: Path | None = None
) -> dict[str, float]:
    """Train the network, write its weights and card; return held-out accuracies by set."""
    torch.manual_seed(derive_seed(settings.seed, "features weights") % 2**31)
    parts = [procedural_textures(settings.procedural, settings.seed, cache)]
    held_out = {
        "procedural, other seeds": procedural_textures(settings.procedural // 5, settings.seed + 1)
    }
    if settings.texture_folder is not None:
        parts.append(scanned_textures(settings.texture_folder, "train"))
        held_out["real textures, val split"] = scanned_textures(settings.texture_folder, "val")
    textures = join_sets(*parts)
    network = SubstanceNetwork()
    if settings.start is not None:
        network.load_state_dict(load_model_file(settings.start)[0])
    steps, minutes = fit(network, textures, settings)
    rng = generator(settings.seed, "features scale")
    weights = sampling_weights(textures, settings.scanned_share)
    standardise(network, draw_crops(textures, weights, settings.held_out_crops, rng, 0.75)[0])
    save_features_network(network, model)
    shipped = load_features_network(model)  # what the metrics run: float16 weights, numpy
    rows, accuracies = [], {}
    for name, group in held_out.items():
        for degraded in (False, True):
            title = f"{name}, {'photographed' if degraded else 'clean'}"
            counts = confusion(shipped, group, settings.held_out_crops, settings.seed, degraded)
            accuracies[title] = float(np.trace(counts) / counts.sum())
            rows += _lines(title, counts)
            _LOGGER.info("%s: accuracy %.3f", title, accuracies[title])
    with atomic_path(card) as temporary:
        temporary.write_text(_card(settings, textures, steps, minutes, rows), encoding="utf-8")
    return accuracies


def _card(
    settings: FeaturesTraining, textures: TextureSet, steps: int, minutes: float, rows: list[str]
) -> str:
    """Return the model card as Markdown."""
    shown = {k: v for k, v in asdict(settings).items() if k not in ("texture_folder", "start")}
    scanned = int(textures.scanned.sum())
    source = f"{len(textures) - scanned} procedural materials"
    if scanned:
        source += f" and {scanned} real tileable textures"
    earlier = "" if settings.start is None else ", going on from weights of the same training"
    lines = [
        "# features",
        "",
        "Substance classifier (wood, plaster, carpet, tile) of 128x128 texture crops. Its class is",
        "the SUBS metric's, its 64 penultimate activations (standardised over training crops) are",
        "the FID features. Figures made with it are named `embedded`; they are not comparable in",
        "size with SUBS by VGG-16 or FID by InceptionV3.",
        "",
        f"Trained by rule `train_features` on {source}",
        "(real ones: train split of a folder that is not shipped): random crops, three quarters",
        "photographed (uneven light, shadows, highlights, white balance, blur, noise, JPEG).",
        f"{steps} steps in {minutes:.1f} minutes{earlier}. Settings:",
        "",
        "```",
        *(f"{name}: {value}" for name, value in shown.items()),
        "```",
        "",
        "Held-out accuracy (all substances drawn equally often; a crop is a random window, so a",
        "window may show no joint of its planks or tiles):",
        "",
        "| crops | n | accuracy | " + " | ".join(SUBSTANCES) + " |",
        "|---|---|---|---|---|---|---|",
        *rows,
        "",
        "Limits: four substances only; plain paint and plain carpet differ by little at a",
        "distance; glossy floors and heavy shadow lower it. Real plaster textures are few. The",
        "training stopped by its wall time, so another machine gives other weights.",
    ]
    return "\n".join(lines) + "\n"
