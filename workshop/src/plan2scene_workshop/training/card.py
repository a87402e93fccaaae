"""The model card (Markdown): a network's training data, its training, and its accuracy."""

from __future__ import annotations

import platform
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from math import isnan
from pathlib import Path
from typing import Any

import torch

from plan2scene.io import atomic_path
from plan2scene.provenance import file_hash, package_versions
from plan2scene_workshop.training.loop import Trained


@dataclass(frozen=True)
class Card:
    """The content of a model card."""

    name: str  #: of the model; its files are ``{name}.safetensors`` and ``{name}.md``
    what: str  #: paragraphs: what the network does
    seen: Sequence[str]  #: lines: each kind of data that it was trained on, or has never seen
    settings: Any  #: a dataclass
    seed: int
    figures: str  #: Markdown: what was measured, on which data, and the table
    limits: str = ""  #: known weaknesses


def write_card(path: str | Path, card: Card, trained: Trained[Any], weights: str | Path) -> None:
    """Write the card of a trained network whose weights are in file `weights`."""
    given = asdict(card.settings).items()
    settings = ", ".join(f"`{key}` {_setting(value)}" for key, value in given)
    target = f"results/training/models/{card.name}.safetensors"
    score = "" if isnan(trained.score) else f", the best evaluation ({trained.score:.4f})"
    minutes = f"{trained.seconds / 60:.1f} minutes with {machine()}"
    facts = [
        f"Command: `snakemake -s workshop/Snakefile -j2 {target}`",
        f"Seed {card.seed}; settings: {settings}.",
        f"Weights of step {trained.step}{score}; {minutes}.",
        f"Versions: Python {platform.python_version()}, {package_versions('torch', 'numpy')}.",
        f"SHA-256 of the weights begins with {file_hash(weights)}.",
    ]
    parts = [
        f"# {card.name}",
        _filled(card.what),
        "## What it saw",
        _items(card.seen),
        "## Training",
        _items(facts),
        "## Figures",
        card.figures.strip(),
    ]
    if card.limits:
        parts += ["## Limits", _filled(card.limits)]
    with atomic_path(path) as temporary:
        temporary.write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def machine() -> str:
    """Return the name of the GPU, or the number of threads and the processor's type."""
    if torch.cuda.is_available():
        return torch.cuda.get_device_name()
    return f"{torch.get_num_threads()} thread(s) of {platform.machine()}"


def table(head: Sequence[str], rows: Mapping[str, Sequence[float | int | str]]) -> str:
    """Return a Markdown table: a line for each name in `rows`, three decimals, - for NaN."""
    lines = [head, ["---"] * len(head), *([name, *map(_cell, row)] for name, row in rows.items())]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _setting(value: object) -> object:
    """Return a setting as the card shows it: of a path only the last part."""
    return Path(value).name if isinstance(value, str) else value


def _cell(value: float | int | str) -> str:
    if isinstance(value, float):
        return "-" if isnan(value) else f"{value:.3f}"
    return str(value)


def _filled(text: str) -> str:
    """Return paragraphs (separated by blank lines) wrapped at 100 characters."""
    return "\n\n".join(textwrap.fill(part, 100) for part in text.strip().split("\n\n"))


def _items(lines: Sequence[str]) -> str:
    """Return a Markdown list wrapped at 100 characters."""
    wrapped = (textwrap.wrap(line, 98, break_on_hyphens=False) for line in lines)
    return "\n".join("- " + "\n  ".join(parts) for parts in wrapped)
