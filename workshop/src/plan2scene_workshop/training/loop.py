"""The training loop of every model: steps, averaged weights, evaluations, checkpoints.

Every random choice in a step derives from (seed, name, step). So the same seed gives the same
weights on one machine, and a run that resumes from its checkpoint ends like one without a stop.
"""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Generic, TypeVar, cast

import numpy as np
import torch
from torch import nn
from torch.optim.swa_utils import AveragedModel, get_ema_multi_avg_fn

from plan2scene.errors import InputError
from plan2scene.io import atomic_path
from plan2scene.seeds import derive_seed, generator

_LOG = logging.getLogger("plan2scene")

Network = TypeVar("Network", bound=nn.Module)
#: (step from 0, that step's generator) -> the weighted parts of the loss; their sum is minimised.
Loss = Callable[[int, np.random.Generator], Mapping[str, torch.Tensor]]


@dataclass(frozen=True)
class TrainerOptions:
    """Options of a training run."""

    name: str  #: names the run's random streams, log lines and checkpoint
    seed: int
    steps: int  #: optimiser steps
    schedule: Callable[[int], float]  #: step from 0 -> factor on each group's learning rate
    clip_norm: float | None = None  #: largest norm of the gradient
    average_decay: float | None = None  #: decay of averaged weights, which are then kept; or none
    evaluate_every: int = 0  #: steps between evaluations; there is also one at the last step
    checkpoint_every: int = 200  #: steps between checkpoints
    log_every: int = 100  #: steps between progress lines
    bfloat16: bool = False  #: run the loss function under autocast


@dataclass(frozen=True)
class Trained(Generic[Network]):
    """The result of a run."""

    network: Network  #: in evaluation mode, with the best-scored weights, or the last ones
    step: int  #: number of the step that its weights are from
    score: float  #: score of these weights; NaN without evaluation
    seconds: float  #: time of all steps and evaluations, including those before a resumption


@dataclass(frozen=True)
class _Best:
    """The best evaluation so far; its score is NaN if there was none."""

    step: int = 0
    score: float = math.nan
    state: dict[str, torch.Tensor] = field(default_factory=dict)


class Trainer(Generic[Network]):
    """A run of training: a network, its loss, its optimiser, and the steps done so far.

    Parameters
    ----------
    network : nn.Module
        On the device to train on.
    loss : Loss
        Draws a batch, runs `network` on it and returns the loss.
    optimiser : torch.optim.Optimizer
        Its learning rates are those where the schedule is 1.
    options : TrainerOptions
    evaluate : callable, optional
        Network in evaluation mode -> score; the network with the highest score is kept.
    run : object
        Identifies this run by its ``repr`` (settings, hashes of data), besides name, seed and
        number of steps: the checkpoint of another run is not continued.
    """

    def __init__(
        self,
        network: Network,
        loss: Loss,
        optimiser: torch.optim.Optimizer,
        options: TrainerOptions,
        *,
        evaluate: Callable[[Network], float] | None = None,
        run: object = None,
    ) -> None:
        if options.steps < 1:
            raise InputError("training steps above 0", str(options.steps))
        self.network, self.loss, self.optimiser = network, loss, optimiser
        self.options, self.evaluate = options, evaluate
        self.run = f"{options.name}, seed {options.seed}, {options.steps} steps, {run!r}"
        self.device = next(network.parameters()).device
        self.rates = [group["lr"] for group in optimiser.param_groups]
        decay = options.average_decay
        self.average = None if decay is None else averaged(network, decay)
        self.step, self.seconds = 0, 0.0
        self.best = _Best()

    @property
    def kept(self) -> Network:
        """The network that is evaluated and returned: the average if there is one."""
        return self.network if self.average is None else cast("Network", self.average.module)

    def train_step(self) -> dict[str, torch.Tensor]:
        """Take one step; return the loss and its parts, detached."""
        options = self.options
        torch.manual_seed(derive_seed(options.seed, options.name, "torch", self.step))
        rng = generator(options.seed, options.name, self.step)
        for group, rate in zip(self.optimiser.param_groups, self.rates, strict=True):
            group["lr"] = rate * options.schedule(self.step)
        self.network.train()
        with torch.autocast(self.device.type, torch.bfloat16, enabled=options.bfloat16):
            parts = self.loss(self.step, rng)
            total = torch.stack(list(parts.values())).sum()
        self.optimiser.zero_grad()
        total.backward()
        if options.clip_norm is not None:
            nn.utils.clip_grad_norm_(self.network.parameters(), options.clip_norm)
        self.optimiser.step()
        if self.average is not None:
            self.average.update_parameters(self.network)
        self.step += 1
        return {name: part.detach() for name, part in {"loss": total, **parts}.items()}

    def fit(self, checkpoint: Path | None = None) -> Trained[Network]:
        """Take the remaining steps; return the best network, or the last without evaluation.

        `checkpoint` is written every few steps and at the end; :meth:`resume` reads it.
        """
        options, recent = self.options, []
        last = time.monotonic()
        while self.step < options.steps:
            recent.append(self.train_step())
            if self.evaluate and self._due(options.evaluate_every):
                self._evaluate(self.evaluate)
            now = time.monotonic()
            self.seconds, last = self.seconds + now - last, now
            if self._due(options.log_every):
                self._log(recent)
                recent = []
            if checkpoint and self._due(options.checkpoint_every):
                self.save(checkpoint)
        network, best = self.kept, self.best
        if not self.evaluate:
            best = _Best(self.step, math.nan, network.state_dict())
        network.load_state_dict(best.state)
        return Trained(network.eval(), best.step, best.score, self.seconds)

    def _due(self, every: int) -> bool:
        """Return whether this step is the last one, or a multiple of `every` (0: never)."""
        return self.step == self.options.steps or (every > 0 and self.step % every == 0)

    def _evaluate(self, evaluate: Callable[[Network], float]) -> None:
        """Score the present network; keep a copy if it is the best so far."""
        with torch.no_grad():
            score = evaluate(self.kept.eval())
        _LOG.info("%s: step %d scores %.4f", self.options.name, self.step, score)
        if math.isnan(self.best.score) or score > self.best.score:
            state = {name: value.clone() for name, value in self.kept.state_dict().items()}
            self.best = _Best(self.step, score, state)

    def _log(self, recent: list[dict[str, torch.Tensor]]) -> None:
        """Write a progress line with the mean losses of recent steps."""
        means = {name: float(sum(p[name] for p in recent)) / len(recent) for name in recent[0]}
        told = ", ".join(f"{name} {value:.4f}" for name, value in means.items())
        _LOG.info("%s: step %d, %s, %.0f s", self.options.name, self.step, told, self.seconds)
        if not math.isfinite(means["loss"]):
            raise InputError(f"a finite loss of {self.options.name}", told)

    def save(self, path: Path) -> None:
        """Write all that :meth:`resume` needs."""
        state = {
            "run": self.run,
            "step": self.step,
            "seconds": self.seconds,
            "network": self.network.state_dict(),
            "optimiser": self.optimiser.state_dict(),
            "average": None if self.average is None else self.average.state_dict(),
            "best": vars(self.best),
        }
        with atomic_path(path) as temporary, temporary.open("wb") as file:
            torch.save(state, file)

    def resume(self, path: Path | None) -> bool:
        """Continue from a file of :meth:`save`; return False if there is none of this run."""
        if path is None or not path.is_file():
            return False
        state = torch.load(path, map_location="cpu", weights_only=True)
        if state["run"] != self.run:
            _LOG.info("%s: the checkpoint is of another run", self.options.name)
            return False
        self.step, self.seconds = state["step"], state["seconds"]
        self.network.load_state_dict(state["network"])
        self.optimiser.load_state_dict(state["optimiser"])
        if self.average is not None:
            self.average.load_state_dict(state["average"])
        self.best = _Best(**state["best"])
        _LOG.info("%s: goes on from step %d", self.options.name, self.step)
        return True


def averaged(network: nn.Module, decay: float) -> AveragedModel:
    """Return an exponential moving average of a network; its decay is smaller in early steps."""

    def update(average: Any, present: Any, count: Any) -> None:
        early = (int(count) + 1) / (int(count) + 11)
        get_ema_multi_avg_fn(min(decay, early))(average, present, count)

    return AveragedModel(network, multi_avg_fn=update, use_buffers=True)


def cosine(step: int, steps: int, *, rise: int = 0, hold: int = 0, floor: float = 0.01) -> float:
    """Return the factor on the learning rate: a linear rise, then a cosine to `floor`.

    `rise` is the number of steps of the rise, `hold` the step until which the rate stays full.
    """
    if step < rise:
        return (step + 1) / rise
    start = max(rise, hold)
    fallen = min(1.0, max(0, step - start) / max(1, steps - start))
    return floor + (1.0 - floor) * 0.5 * (1.0 + math.cos(math.pi * fallen))


def best_device() -> str:
    """Return ``"cuda"`` if there is a GPU, else ``"cpu"``."""
    return "cuda" if torch.cuda.is_available() else "cpu"
