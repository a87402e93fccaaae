"""Training of the texture models: Synth (delta-HSV, substance head) and NaiveSynth.

The loss is the sum of the errors of Gram matrices (of fixed filters, or of VGG-19), the log
spectrum by sectors, the colour distribution, differentiable COLOR and FREQ, and the cross-entropy
of the substance.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch
from torch import nn
from torch.nn import functional

from plan2scene.seeds import derive_seed, generator
from plan2scene.textures.model.noise import CHANNELS, OCTAVES
from plan2scene.textures.model.statistics import SpectrumStatistics
from plan2scene.textures.model.texture_model import (
    Architecture,
    Encoding,
    StatisticsEncoder,
    TextureModel,
)
from plan2scene_workshop.texture.data import TextureSet, draw_crops, sampling_weights
from plan2scene_workshop.texture.degradation import CROP_PX, UNEVEN_LIGHT, photographed
from plan2scene_workshop.texture.losses import (
    colour_distance,
    frequency_distance,
    histogram_distance,
    spectrum_distance,
)
from plan2scene_workshop.texture.settings import TextureSettings
from plan2scene_workshop.texture.vgg_statistics import load_statistics
from plan2scene_workshop.training.loop import Trained, Trainer, TrainerOptions


def draw_batch(
    textures: TextureSet, weights: np.ndarray, size: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return inputs and targets (n, 128, 128, 3) uint8, and substances (n,)."""
    crops, substances = draw_crops(textures, weights, size, rng, closest_px=116)
    return photographed(crops, rng, UNEVEN_LIGHT, 0.6), crops, substances


class TextureLoss:
    """The loss of a random batch of 64-px windows of tiles, or of whole tiles."""

    def __init__(
        self, model: TextureModel, textures: TextureSet, settings: TextureSettings, device: str
    ) -> None:
        self.model, self.textures = model, textures
        self.settings, self.device = settings, device
        self.weights = sampling_weights(textures, settings.scanned_share)
        self.filters = load_statistics(
            settings.statistics, settings.statistics_path, levels=settings.levels, device=device
        )
        self.spectrum = SpectrumStatistics().to(device)

    def __call__(self, step: int, rng: np.random.Generator) -> dict[str, torch.Tensor]:
        """Return the weighted parts of the loss of a step."""
        settings, device = self.settings, self.device
        whole = rng.random() < settings.tile_share or step >= settings.steps
        size, side = (settings.tile_batch, CROP_PX) if whole else (settings.batch, CROP_PX // 2)
        inputs, crops, substances = draw_batch(self.textures, self.weights, size, rng)
        encoding = self.model.encode(_tensor(inputs, device))
        seeds = torch.from_numpy(rng.random((size, OCTAVES, CHANNELS), dtype=np.float32)).to(device)
        tiles = self.model.decode(encoding.embedding, seeds, CROP_PX, _window(rng, side))
        rows, columns = _window(rng, side)
        targets = _tensor(crops, device)[:, :, rows, columns]
        every = side // 64
        sparse = tiles[:, :, ::every, ::every], targets[:, :, ::every, ::every]
        parts = {
            "gram": self.filters.distance(tiles, targets).mean(),
            "spectrum": settings.spectrum * spectrum_distance(self.spectrum, tiles, targets).mean(),
            "colour": settings.colour * colour_distance(*sparse).mean(),
            "histogram": settings.histogram * histogram_distance(*sparse).mean(),
            "frequency": tiles.new_zeros(()),
            "substance": settings.substance * _cross_entropy(encoding, substances),
        }
        if whole:
            parts["frequency"] = settings.frequency * frequency_distance(tiles, targets).mean()
        return parts


def texture_trainer(
    architecture: Architecture,
    textures: TextureSet,
    settings: TextureSettings,
    seed: int,
    *,
    device: str = "cpu",
    run: object = None,
) -> Trainer[TextureModel]:
    """Return a trainer for a new texture model, before its first step (see :func:`warm_up`)."""
    torch.manual_seed(derive_seed(seed, "texture model"))
    model = TextureModel(architecture).to(device)
    model.decoder.low_precision = settings.low_precision
    if isinstance(model.encoder, StatisticsEncoder):
        model.encoder.dropout = settings.dropout
    optimiser = torch.optim.Adam(
        model.parameters(), lr=settings.learning_rate, weight_decay=settings.weight_decay
    )
    options = TrainerOptions(
        "texture",
        seed,
        settings.steps + settings.finish,
        settings.rate,
        clip_norm=settings.clip_norm,
    )
    loss = TextureLoss(model, textures, settings, device)
    return Trainer(model, loss, optimiser, options, run=(architecture, settings, run))


def train_texture_model(
    architecture: Architecture,
    textures: TextureSet,
    settings: TextureSettings,
    seed: int,
    *,
    device: str = "cpu",
    checkpoint: Path | None = None,
    run: object = None,
) -> Trained[TextureModel]:
    """Return a trained texture model.

    Training continues from `checkpoint` if it is of this run; `run` identifies the textures.
    """
    trainer = texture_trainer(architecture, textures, settings, seed, device=device, run=run)
    if not trainer.resume(checkpoint):
        warm_up(trainer.network, textures, settings, seed)
    return trainer.fit(checkpoint)


def warm_up(
    model: TextureModel, textures: TextureSet, settings: TextureSettings, seed: int
) -> None:
    """Train a statistics encoder alone, so that its codes keep the statistics and substance."""
    encoder, device = model.encoder, next(model.parameters()).device
    if not isinstance(encoder, StatisticsEncoder):
        return
    rng = generator(seed, "texture warm-up")
    weights = sampling_weights(textures, settings.scanned_share)
    batches = [draw_batch(textures, weights, 16, rng) for _ in range(settings.warm_up // 16)]
    with torch.no_grad():
        inputs = torch.cat([encoder.features(_tensor(given, device)) for given, _, _ in batches])
        features = torch.cat([encoder.features(_tensor(crops, device)) for _, crops, _ in batches])
    labels = np.concatenate([substances for _, _, substances in batches])
    encoder.standardise(features)
    targets = ((features - encoder.centre) / encoder.scale).clamp(-4.0, 4.0)
    probe = nn.Linear(model.architecture.code_dim, targets.shape[1]).to(device)

    def loss(step: int, rng: np.random.Generator) -> dict[str, torch.Tensor]:
        chosen = rng.integers(0, len(inputs), 64)
        encoding = model.embed(encoder.code_of_features(inputs[chosen]), None)
        code = encoding.embedding
        return {
            "statistics": (probe(code) - targets[chosen]).square().mean(),
            "substance": 0.3 * _cross_entropy(encoding, labels[chosen]),
            # The probe does not fix the size of the codes: keep it near that of unit noise.
            "size": 0.01 * (code.square().mean() - 1.0).square(),
        }

    both = nn.ModuleList([model, probe])
    optimiser = torch.optim.AdamW(
        both.parameters(),
        lr=settings.warm_up_learning_rate,
        weight_decay=settings.warm_up_weight_decay,
    )
    options = TrainerOptions("texture warm-up", seed, settings.warm_up_steps, lambda step: 1.0)
    Trainer(both, loss, optimiser, options).fit()


def _cross_entropy(encoding: Encoding, substances: np.ndarray) -> torch.Tensor:
    """Return the substance head's cross-entropy, 0 without a head."""
    if encoding.logits is None:
        return encoding.embedding.new_zeros(())
    labels = torch.from_numpy(substances).to(encoding.logits.device)
    return functional.cross_entropy(encoding.logits, labels)


def _tensor(images: np.ndarray, device: torch.device | str) -> torch.Tensor:
    """Return images (n, h, w, 3) uint8 as (n, 3, h, w) float32 in [0, 1]."""
    return torch.from_numpy(images).to(device).permute(0, 3, 1, 2).float() / 255.0


def _window(rng: np.random.Generator, side: int) -> tuple[slice, slice]:
    """Return a random `side` x `side` window of a 128-px image."""
    row, column = (int(v) for v in rng.integers(0, CROP_PX - side + 1, 2))
    return slice(row, row + side), slice(column, column + side)
