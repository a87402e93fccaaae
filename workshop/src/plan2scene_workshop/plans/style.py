"""Random drawing styles of plans: every choice that a draughtsman makes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

Colour = tuple[int, int, int]

#: Options of each choice with their weights, for training.
CHOICES: dict[str, dict[str, float]] = {
    "wall": {
        "solid": 6.0,
        "grey": 2.0,
        "outline": 2.0,
        "double": 2.5,
        "hatched": 2.0,
        "line": 2.0,
        "mixed": 4.0,
        "crossed": 1.0,
    },
    "door": {
        "arc": 6.0,
        "thin_arc": 3.0,
        "leaf": 1.5,
        "slanted": 1.0,
        "dashed_arc": 1.0,
        "gap": 3.0,
        "box": 2.0,
        "sliding": 0.7,
    },
    "window": {
        "lines": 4.0,
        "pane": 3.0,
        "filled": 1.5,
        "sill": 2.0,
        "ticks": 1.0,
        "swing": 0.7,
        "gap": 0.4,
        "line": 1.5,
        "niche": 2.5,
        "none": 0.8,
    },
    "passage": {"gap": 4.0, "dashed": 1.5, "lines": 1.0, "line": 1.5, "dotted": 0.5},
    "rail": {"outline": 4.0, "dashed": 1.5, "line": 1.0, "posts": 0.7},
    "floor": {"none": 6.0, "one": 1.5, "by_type": 2.5, "pattern": 2.0},
    "furniture": {"none": 2.5, "lines": 6.0, "filled": 2.0},
    "names": {"none": 1.5, "names": 2.5, "areas": 3.5, "dimensions": 2.5, "both": 0.7},
    "chains": {"none": 4.0, "total": 1.5, "steps": 3.0},
    "unit": {"m": 3.0, "cm": 2.0, "mm": 2.0, "ft": 1.3},
    "language": {"en": 3, "de": 2, "fr": 2, "es": 2, "it": 2, "nl": 2, "sv": 0.7, "he": 0.4},
}
#: Options of the benchmark. Most are in no training drawing; some common ones are mixed in.
HELD_OUT: dict[str, dict[str, float]] = {
    "wall": {"dotted": 1.0, "bricks": 1.0, "hollow_thick": 1.0, "solid": 1.0},
    "door": {"double_arc": 1.0, "filled_arc": 1.0, "arc": 1.0},
    "window": {"cross": 1.0, "thick_frame": 1.0, "lines": 1.0},
    "floor": {"gradient": 1.0, "none": 1.5},
    "font": {"serif": 1.0},
}

#: Probabilities that an inner door is a passage (one is drawn per style); homes have few passages.
OPENED = (0.0, 0.2, 0.5)


@dataclass(frozen=True)
class PlanStyle:
    """The choices of one drawing; lengths in metres, line widths in pixels."""

    wall: str
    door: str
    outer_door: str
    swing: float  #: opening angle of leaves, degrees
    window: str
    passage: str
    rail: str
    floor: str
    furniture: str
    names: str
    chains: str
    unit: str
    language: str
    font: str
    inner_depth: float
    outer_depth: float
    rail_depth: float
    cut_corners: float
    opened: float  #: probability that an inner door is a passage
    paper: Colour
    ink: Colour  #: of walls
    pen: Colour  #: of thin lines
    tint: Colour  #: of floors and filled things
    accent: Colour  #: of dimensions and windows
    weight: int  #: width of outlines in pixels
    thin: int  #: width of all other lines in pixels
    text_height: float  #: metres
    hand: bool  #: drawn by hand


def draw_style(rng: np.random.Generator, *, held_out: bool = False) -> PlanStyle:
    """Return a random style for training, or from the held-out options."""

    def choose(key: str) -> str:
        options = CHOICES.get(key, {"sans": 1.0})
        if held_out:
            options = HELD_OUT.get(key, options)
        weights = np.array(list(options.values()), float)
        return str(rng.choice(list(options), p=weights / weights.sum()))

    wall = choose("wall")
    hand = wall == "line" and bool(rng.random() < 0.5)
    inner = float(rng.uniform(0.07, 0.16))
    outer = inner if rng.random() < 0.25 else float(rng.uniform(max(0.15, inner), 0.42))
    if wall == "mixed":  # solid outer walls; inner walls are a line
        inner, outer = float(rng.uniform(0.02, 0.06)), float(rng.uniform(0.08, 0.3))
    if wall == "line":
        inner = outer = float(rng.uniform(0.02, 0.06))
    inverse = rng.random() < 0.04
    paper = _near_white(rng) if not inverse else tuple(int(v) for v in rng.integers(10, 110, 3))
    dark = tuple(int(v) for v in rng.integers(0, 60, 3)) if rng.random() < 0.3 else (0, 0, 0)
    ink: tuple[int, ...] = dark
    if rng.random() < 0.12:
        ink = tuple(int(v) for v in rng.integers(30, 150, 3))
    pen: tuple[int, ...] = (int(rng.integers(0, 150)),) * 3
    if inverse:
        ink, pen = (int(rng.integers(200, 256)),) * 3, (int(rng.integers(160, 256)),) * 3
    tint = tuple(int(v) for v in rng.integers(90 if rng.random() < 0.15 else 150, 250, 3))
    if inverse:
        tint = tuple(int(v * 0.5) for v in tint)
    accent = tuple(int(v) for v in rng.integers(0, 200, 3)) if rng.random() < 0.4 else pen
    door = "gap" if hand and rng.random() < 0.6 else choose("door")
    style = PlanStyle(
        wall=wall,
        door=door,
        outer_door=door if rng.random() < 0.6 else choose("door"),
        swing=90.0 if rng.random() < 0.7 else float(rng.uniform(30, 80)),
        window="gap" if hand and rng.random() < 0.3 else choose("window"),
        passage=choose("passage"),
        rail=choose("rail"),
        floor="none" if hand else choose("floor"),
        furniture="none" if hand and rng.random() < 0.6 else choose("furniture"),
        names=choose("names"),
        chains="none" if hand else choose("chains"),
        unit=choose("unit"),
        language=choose("language"),
        font="hand" if hand else (choose("font") if held_out else _font(rng)),
        inner_depth=inner,
        outer_depth=outer,
        rail_depth=float(rng.uniform(0.03, 0.1)),
        cut_corners=0.03 if rng.random() < 0.35 else 0.0,
        paper=paper,  # type: ignore[arg-type]
        ink=ink,  # type: ignore[arg-type]
        pen=pen,  # type: ignore[arg-type]
        tint=tint,  # type: ignore[arg-type]
        accent=accent,  # type: ignore[arg-type]
        weight=int(rng.integers(1, 4)),
        thin=1 if rng.random() < 0.75 else 2,
        text_height=float(rng.uniform(0.16, 0.36)),
        opened=0.0 if held_out else float(rng.choice(OPENED)),
        hand=hand,
    )
    if wall == "mixed" and rng.random() < 0.4:  # the sparest drawings: no leaf, often no window
        return replace(style, door="gap", window="none" if rng.random() < 0.5 else style.window)
    return style


def _near_white(rng: np.random.Generator) -> tuple[int, ...]:
    """Return the colour of paper: mostly white."""
    if rng.random() < 0.6:
        return (255, 255, 255)
    return tuple(int(v) for v in rng.integers(225, 256) - rng.integers(0, 14, 3))


def _font(rng: np.random.Generator) -> str:
    """Return a random font for training."""
    return str(
        rng.choice(
            ["sans", "bold", "mono", "hand", "oblique", "narrow"],
            p=[0.35, 0.15, 0.1, 0.1, 0.1, 0.2],
        )
    )
