"""Training views of drawings: rotated, warped, degraded, cut to the network's size."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import torch

from plan2scene.seeds import generator
from plan2scene_workshop.homes.floorplans import generate_house
from plan2scene_workshop.plans.drawing import DrawnPlan, draw_plan
from plan2scene_workshop.plans.paper import bend, homography, worn
from plan2scene_workshop.plans.settings import PlanSettings
from plan2scene_workshop.plans.style import draw_style

#: Share of views that are photographed (not scanned or saved), and share turned by up to 45 deg.
PHOTOGRAPHED, TURNED = 0.15, 0.06
#: Share of drawings with two storeys on one page.
STOREYS = 0.1


class Drawings:
    """Training drawings by number; each is drawn when it is first used."""

    def __init__(self, settings: PlanSettings, seed: int) -> None:
        self.settings, self.seed = settings, seed
        self.get = lru_cache(maxsize=None)(self._draw)

    def _draw(self, number: int) -> DrawnPlan:
        """Return drawing `number`."""
        rng = generator(self.seed, "plan drawing", number)
        low, high = np.log([self.settings.ppm_low, self.settings.ppm_high])
        ppm = float(np.exp(rng.uniform(low, high)))
        house = generate_house(f"train_{number}", self.seed)
        style, finer = draw_style(rng), int(rng.integers(1, 4))
        drawn = draw_plan(house, style, ppm, rng, finer=finer)
        if rng.random() >= STOREYS:
            return drawn
        house = generate_house(f"train_{number}_above", self.seed)
        return _beside(drawn, draw_plan(house, style, ppm, rng, finer=finer))


def _beside(first: DrawnPlan, second: DrawnPlan) -> DrawnPlan:
    """Return two storeys on one page; the result's `plan` is that of the first."""
    heights = [drawn.labels.shape[0] for drawn in (first, second)]
    images, labels = [], []
    for drawn in (first, second):
        low = ((0, max(heights) - drawn.labels.shape[0]), (0, 0))
        images.append(np.pad(drawn.image, (*low, (0, 0)), mode="edge"))
        labels.append(np.pad(drawn.labels, low))
    return replace(first, image=np.hstack(images), labels=np.hstack(labels))


def other_drawing(
    number: int, seed: int, ppm: float, *, held_out: bool, finer: int = 2, opened: float = 0.0
) -> DrawnPlan:
    """Return a drawing of a home that is not trained on; if `held_out`, its style is not either.

    If `opened` is not 0, it replaces the style's probability that an inner door is a passage.
    """
    rng = generator(seed, "other plan drawing", held_out, number)
    style = draw_style(rng, held_out=held_out)
    if opened:
        style = replace(style, opened=opened)
    return draw_plan(generate_house(f"test_{number}", seed + 1), style, ppm, rng, finer=finer)


def draw_view(
    drawn: DrawnPlan, side: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Return a view (side, side, 3) uint8 of a drawing and its labels (side, side) uint8."""
    h, w = drawn.labels.shape
    photographed = bool(rng.random() < PHOTOGRAPHED)
    turn = float(rng.normal(0, 1.2)) if rng.random() < 0.5 else 0.0
    if rng.random() < TURNED:
        turn = float(rng.uniform(-45, 45))
    move = homography((h, w), rng, turn=turn, keystone=0.05 if photographed else 0.0)
    if rng.random() < 0.5:  # a quarter turn
        move = np.array([[0.0, -1, h], [1, 0, 0], [0, 0, 1]]) @ move
        h, w = w, h
    if rng.random() < 0.5:  # this mirrors letters too, which does not matter for walls
        move = np.array([[-1.0, 0, w], [0, 1, 0], [0, 0, 1]]) @ move
    zoom = float(np.exp(rng.uniform(-0.3, 0.3)))
    spare = side - np.array([w, h]) * zoom
    # A plan that fits lies anywhere on the view; a larger one is seen in part.
    offset = rng.uniform(np.minimum(0, spare), np.maximum(0, spare))
    move = np.array([[zoom, 0, offset[0]], [0, zoom, offset[1]], [0, 0, 1]]) @ move
    wobble = float(rng.uniform(0, 1.5)) if rng.random() < 0.2 else 0.0
    edge = drawn.image[0, 0] if rng.random() < 0.8 else rng.integers(0, 256, 3)
    beyond = (int(edge[0]), int(edge[1]), int(edge[2]))
    image, labels = bend(
        drawn.image, drawn.labels, move, (side, side), rng, wobble=wobble, beyond=beyond
    )
    return worn(image, rng, photographed=photographed), labels


def draw_batch(drawings: Drawings, rng: np.random.Generator) -> tuple[torch.Tensor, torch.Tensor]:
    """Return views (n, 3, h, w) float32 in [0, 1] and labels (n, h, w) int64 of random drawings."""
    settings = drawings.settings
    images, labels = [], []
    for _ in range(settings.batch):
        drawn = drawings.get(int(rng.integers(settings.drawings)))
        image, truth = draw_view(drawn, settings.side, rng)
        if rng.random() < settings.blank_share:
            image, truth = _without_plan(image, truth)
        images.append(image)
        labels.append(truth)
    pixels = torch.from_numpy(np.stack(images)).permute(0, 3, 1, 2).float() / 255
    return pixels, torch.from_numpy(np.stack(labels)).long()


def _without_plan(image: np.ndarray, labels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a view in which the plan is painted over with the median colour around it."""
    rows, columns = np.nonzero(labels)
    if len(rows) == 0:
        return image, labels
    paper = np.median(image[labels == 0].reshape(-1, 3), axis=0) if (labels == 0).any() else 255
    image = image.copy()
    pad = 3
    place = (
        slice(max(0, rows.min() - pad), rows.max() + pad),
        slice(max(0, columns.min() - pad), columns.max() + pad),
    )
    image[place] = paper
    return image, np.zeros_like(labels)
