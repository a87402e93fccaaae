"""Training of the texture models: Synth (delta-HSV, substance head) and NaiveSynth.

The loss is the error of Gram matrices (of fixed filters, or of VGG-19), the log spectrum by
sectors, the colour distribution, COLOR and FREQ with gradients, and cross-entropy of the
substance. Most steps draw 64-px windows of the tile, which
cost a quarter; some draw the whole tile for the coarse structure. First a
statistics encoder learns alone to keep the crop's statistics and substance in its code, because
decoding is what costs.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import torch
from torch import nn
from torch.nn import functional

from plan2scene.io import atomic_path
from plan2scene.seeds import derive_seed, generator
from plan2scene.textures.model.encoder import StatisticsEncoder
from plan2scene.textures.model.network import Architecture, Encoding, TextureModel
from plan2scene.textures.model.noise import CHANNELS, OCTAVES
from plan2scene.textures.model.statistics import (
    SpectrumStatistics,
    colour_distance,
    frequency_distance,
    histogram_distance,
)
from plan2scene.textures.model.vgg_statistics import load_statistics
from plan2scene_workshop.texture.data import (
    CROP_PX,
    Batch,
    TextureSet,
    draw_batch,
    sampling_weights,
)
from plan2scene_workshop.texture.settings import TextureTraining, schedule

_LOGGER = logging.getLogger("plan2scene")


@dataclass(frozen=True)
class Losses:
    """Parts of the loss of one batch, before weighting."""

    gram: torch.Tensor
    spectrum: torch.Tensor
    colour: torch.Tensor
    histogram: torch.Tensor
    frequency: torch.Tensor
    substance: torch.Tensor


class TextureTrainer:
    """One model, its optimiser and its losses; the state can be saved and continued."""

    def __init__(
        self, architecture: Architecture, options: TextureTraining, seed: int, device: str = "cpu"
    ) -> None:
        torch.manual_seed(derive_seed(seed, "texture model") % 2**31)
        self.model = TextureModel(architecture).to(device)
        self.model.decoder.low_precision = options.low_precision
        if isinstance(self.model.encoder, StatisticsEncoder):
            self.model.encoder.dropout = options.dropout
        self.options, self.seed, self.device = options, seed, device
        self.filters = load_statistics(
            options.statistics, options.statistics_path, levels=options.levels, device=device
        )
        self.spectrum = SpectrumStatistics().to(device)
        self.optimiser = torch.optim.Adam(
            self.model.parameters(), lr=options.learning_rate, weight_decay=options.weight_decay
        )
        self.step = 0
        self.seconds = 0.0

    def losses(self, batch: Batch, rng: np.random.Generator, side: int) -> Losses:
        """Return the losses of a batch on random `side` x `side` windows of tiles and targets."""
        inputs, targets = self._tensor(batch.inputs), self._tensor(batch.targets)
        encoding = self.model.encode(inputs)
        draws = rng.random((len(inputs), OCTAVES, CHANNELS), dtype=np.float32)
        seeds = torch.from_numpy(draws).to(self.device)
        tiles = self.model.decode(encoding.embedding, seeds, CROP_PX, _window(rng, side))
        rows, columns = _window(rng, side)
        targets = targets[:, :, rows, columns]
        step = side // 64
        sparse = tiles[:, :, ::step, ::step], targets[:, :, ::step, ::step]
        return Losses(
            self.filters.distance(tiles, targets).mean(),
            self.spectrum.distance(tiles, targets).mean(),
            colour_distance(*sparse).mean(),
            histogram_distance(*sparse).mean(),
            frequency_distance(tiles, targets).mean() if side == CROP_PX else tiles.new_zeros(()),
            self._cross_entropy(encoding, torch.from_numpy(batch.substances).to(self.device)),
        )

    def warm_up(self, textures: TextureSet, weights: np.ndarray) -> None:
        """Train a statistics encoder alone to tell statistics and substance from its codes."""
        encoder, options = self.model.encoder, self.options
        if not isinstance(encoder, StatisticsEncoder):
            return
        rng = generator(self.seed, "texture warm-up")
        batches = [draw_batch(textures, weights, 16, rng) for _ in range(options.warm_up // 16)]
        with torch.no_grad():
            inputs = torch.cat([encoder.features(self._tensor(b.inputs)) for b in batches])
            targets = torch.cat([encoder.features(self._tensor(b.targets)) for b in batches])
        labels = torch.from_numpy(np.concatenate([b.substances for b in batches])).to(self.device)
        encoder.standardise(targets)
        targets = ((targets - encoder.centre) / encoder.scale).clamp(-4.0, 4.0)
        probe = nn.Linear(self.model.architecture.code_dim, targets.shape[1]).to(self.device)
        optimiser = torch.optim.AdamW(
            [*self.model.parameters(), *probe.parameters()], lr=2e-3, weight_decay=0.01
        )
        for _ in range(3 * options.warm_up // 8):
            chosen = torch.from_numpy(rng.integers(0, len(inputs), 64))
            encoding = self.model.embed(encoder.code_of_features(inputs[chosen]), None)
            code = encoding.embedding
            error = (probe(code) - targets[chosen]).square().mean()
            # The probe leaves the codes' size open: keep it near that of unit noise.
            size = 0.01 * (code.square().mean() - 1.0).square()
            cross_entropy = self._cross_entropy(encoding, labels[chosen])
            optimiser.zero_grad()
            (error + 0.3 * cross_entropy + size).backward()
            optimiser.step()
        _LOGGER.info(
            "warm-up: %d crops, statistics %.3f, substance %.3f",
            len(inputs),
            float(error.detach()),
            float(cross_entropy.detach()),
        )

    def _cross_entropy(self, encoding: Encoding, labels: torch.Tensor) -> torch.Tensor:
        """Return the substance head's cross-entropy, 0 without a head."""
        if encoding.logits is None:
            return encoding.embedding.new_zeros(())
        return functional.cross_entropy(encoding.logits, labels)

    def train_step(self, textures: TextureSet, weights: np.ndarray) -> Losses:
        """Run one step; everything random in it derives from (seed, step)."""
        options = self.options
        rng = generator(self.seed, "texture step", self.step)
        torch.manual_seed(derive_seed(self.seed, "texture dropout", self.step) % 2**31)
        whole = rng.random() < options.tile_share or self.step >= options.steps
        size, side = (options.tile_batch, CROP_PX) if whole else (options.batch, CROP_PX // 2)
        losses = self.losses(draw_batch(textures, weights, size, rng), rng, side)
        total = (
            losses.gram
            + options.spectrum * losses.spectrum
            + options.colour * losses.colour
            + options.histogram * losses.histogram
            + options.frequency * losses.frequency
            + options.substance * losses.substance
        )
        for group in self.optimiser.param_groups:
            group["lr"] = options.learning_rate * self._rate()
        self.optimiser.zero_grad()
        total.backward()
        torch.nn.utils.clip_grad_norm_(self.model.parameters(), 2.0)
        self.optimiser.step()
        self.step += 1
        return losses

    def _rate(self) -> float:
        """Return the share of the learning rate at this step."""
        options = self.options
        if self.step < options.steps:
            return schedule(self.step / options.steps)
        return 0.25 * schedule(0.6 + 0.4 * (self.step - options.steps) / max(options.finish, 1))

    def save(self, path: Path) -> None:
        """Write all that :meth:`resume` needs."""
        state = {
            "run": self._run(),
            "step": self.step,
            "seconds": self.seconds,
            "model": self.model.state_dict(),
            "optimiser": self.optimiser.state_dict(),
        }
        with atomic_path(path) as temporary:
            torch.save(state, temporary)

    def resume(self, path: Path) -> bool:
        """Continue from a file of :meth:`save`; False for one of another run (nothing changes)."""
        state = torch.load(path, map_location=self.device, weights_only=True)
        if state.get("run") != self._run():
            return False
        self.step, self.seconds = int(state["step"]), float(state["seconds"])
        self.model.load_state_dict(state["model"])
        self.optimiser.load_state_dict(state["optimiser"])
        return True

    def _run(self) -> str:
        """Return what makes a run: all but its length, which may change on the way."""
        options = replace(self.options, steps=0, finish=0)
        return repr((self.seed, self.model.architecture, options))

    def _tensor(self, images: np.ndarray) -> torch.Tensor:
        tensor = torch.from_numpy(images).to(self.device).permute(0, 3, 1, 2)
        return tensor.float() / 255.0


def _window(rng: np.random.Generator, side: int) -> tuple[slice, slice]:
    """Return a random `side` x `side` window of a 128-px image."""
    row, column = (int(v) for v in rng.integers(0, CROP_PX - side + 1, 2))
    return slice(row, row + side), slice(column, column + side)


def train_texture_model(
    architecture: Architecture,
    textures: TextureSet,
    options: TextureTraining,
    seed: int,
    *,
    checkpoint: Path | None = None,
    device: str = "cpu",
) -> tuple[TextureModel, float]:
    """Return a trained texture model and the seconds that took, earlier calls included.

    Parameters
    ----------
    checkpoint : path, optional
        Written every 200 steps, and continued from where it exists.
    device : str
        ``"cpu"`` or ``"cuda"``.
    """
    trainer = TextureTrainer(architecture, options, seed, device)
    if checkpoint is not None and checkpoint.is_file():
        resumed = trainer.resume(checkpoint)
        _LOGGER.info(
            "continued from step %d" if resumed else "other run's checkpoint, step %d", trainer.step
        )
    weights = sampling_weights(textures, options.scanned_share)
    trainer.model.train()
    last = time.monotonic()
    if trainer.step == 0:
        trainer.warm_up(textures, weights)
    sums: dict[str, float] = {}
    while trainer.step < options.steps + options.finish:
        _accumulate(sums, trainer.train_step(textures, weights))
        now = time.monotonic()
        trainer.seconds, last = trainer.seconds + now - last, now
        if trainer.step % 50 == 0:
            means = " ".join(f"{k} {v / sums['n']:.3f}" for k, v in sums.items() if k != "n")
            _LOGGER.info("step %d %s, %.0f s", trainer.step, means, trainer.seconds)
            sums = {}
        if checkpoint is not None and trainer.step % 200 == 0:
            trainer.save(checkpoint)
    return trainer.model.eval(), trainer.seconds


def _accumulate(sums: dict[str, float], losses: Losses) -> None:
    """Add the losses of a step to running sums."""
    values: Mapping[str, torch.Tensor] = vars(losses)
    for name, value in values.items():
        sums[name] = sums.get(name, 0.0) + float(value.detach())
    sums["n"] = sums.get("n", 0.0) + 1
