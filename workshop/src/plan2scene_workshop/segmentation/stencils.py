"""Outlines of things that boxes cannot be: foliage, people, bars, rags. All (n, m) bool."""

from __future__ import annotations

import cv2
import numpy as np

Array = np.ndarray
Rng = np.random.Generator
_SIDE = 96


def foliage(rng: Rng) -> Array:
    """Return leaves on stems that rise from the middle of the lower edge."""
    canvas = np.zeros((_SIDE, _SIDE), np.uint8)
    root = np.array([_SIDE / 2, _SIDE - 1])
    length = int(rng.integers(5, 18))
    wide = max(1, int(length * rng.uniform(0.08, 0.5)))
    for _ in range(int(rng.integers(3, 9))):
        tip = np.array([rng.uniform(0.05, 0.95), rng.uniform(0.05, 0.6)]) * _SIDE
        cv2.line(canvas, root.astype(int).tolist(), tip.astype(int).tolist(), 1, 1)
        for share in np.linspace(0.3, 1, int(rng.integers(3, 9))):
            place = root + share * (tip - root) + rng.normal(0, 3, 2)
            angle = float(rng.uniform(0, 360))
            cv2.ellipse(canvas, place.astype(int).tolist(), (length, wide), angle, 0, 360, 1, -1)
    return canvas > 0


def person(rng: Rng) -> Array:
    """Return somebody who stands, seen from in front."""
    canvas = np.zeros((_SIDE, _SIDE // 2), np.uint8)
    middle = _SIDE // 4
    cv2.ellipse(canvas, (middle, 8), (5, 7), 0, 0, 360, 1, -1)
    wide = int(rng.integers(9, 14))
    cv2.ellipse(canvas, (middle, 32), (wide, 18), 0, 0, 360, 1, -1)
    cv2.rectangle(canvas, (middle - wide + 2, 20), (middle + wide - 2, 50), 1, -1)
    for side in (-1, 1):
        hip, foot = (middle + side * 4, 48), (middle + side * int(rng.integers(3, 10)), 95)
        cv2.line(canvas, hip, foot, 1, int(rng.integers(6, 10)))
        hand = (middle + side * int(rng.integers(6, 21)), int(rng.integers(25, 56)))
        cv2.line(canvas, (middle + side * (wide - 2), 20), hand, 1, 5)
    return canvas > 0


def bars(rng: Rng) -> Array:
    """Return a frame with bars across or down: backs of chairs, cots, airers, railings."""
    count = int(rng.integers(3, 14))
    phase = np.linspace(0, count, _SIDE, endpoint=False) % 1
    line = phase < rng.uniform(0.15, 0.6)
    canvas = np.broadcast_to(line, (_SIDE, _SIDE)).copy()
    rim = int(rng.integers(3, 9))
    canvas[:rim] = canvas[-rim:] = True
    canvas[:, :rim] = canvas[:, -rim:] = True
    return canvas if rng.random() < 0.7 else canvas.T


def rag(rng: Rng) -> Array:
    """Return an uneven blob: clothes on a floor, cowhide, throws, bags."""
    angle = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    radius = np.full(40, 0.75)
    for wave in range(2, 6):
        radius += rng.normal(0, 0.12) * np.cos(wave * angle + rng.uniform(0, 6))
    radius = np.clip(radius, 0.2, 1) * (_SIDE / 2 - 1)
    outline = np.stack([np.cos(angle), np.sin(angle)], 1) * radius[:, None] + _SIDE / 2
    canvas = np.zeros((_SIDE, _SIDE), np.uint8)
    cv2.fillPoly(canvas, [outline.astype(np.int32)], 1)
    return canvas > 0


def disc() -> Array:
    """Return a circle: round tables, rugs, stools, wheels."""
    y, x = np.mgrid[:_SIDE, :_SIDE] - (_SIDE - 1) / 2
    return np.asarray(x * x + y * y < (_SIDE / 2) ** 2)
