"""Random light in training homes: how it changes the colours of surfaces in photos.

A texture's code hardly depends on the light (its network sees colours relative to the crop's own),
so light is applied to embeddings, anew each time that a house is drawn: the exposure and balance
of the house, the light of each room, shade on each surface. The result is the look of a surface in
its own room, which the network must predict. The embeddings from photos differ further: photos
show only a part, the code has noise, and some crops show the next room's surface through a door.

Axes: log brightness, warmth (red up, blue down) and tint (red, blue) of linear colours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plan2scene.colour import from_log_axes, linear_to_srgb, log_axes, srgb_to_linear
from plan2scene.house import SURFACES
from plan2scene.propagation.graph import HouseGraph

#: Index of the first of the embedding's three colour values.
_COLOUR = 8
#: Log red and log blue, relative to green, of one unit of warmth (lamp light against daylight: the
#: rooms of the two real development flats lie along this line, correlation -.9).
_WARMTH = np.array([1.0, -0.5])


@dataclass(frozen=True)
class Light:
    """Standard deviations of brightness and warmth; each house draws its own from a "range"."""

    exposure: tuple[float, float]  #: mean and deviation of the houses' brightness
    warmth: tuple[float, float]  #: mean and deviation of the houses' warmth
    room_brightness: tuple[float, float]  #: range
    room_warmth: tuple[float, float]  #: range
    room_tint: float
    surface: tuple[float, float]  #: brightness and warmth of the shade on each surface
    photo: tuple[float, float]  #: error of brightness and warmth in photos of a surface
    code: float  #: noise of the codes from photos, relative to the codes' deviation over surfaces
    next_room: float  #: probability that crops show the next room's surface, partly or fully


#: Remaining light of rendered photos after the light corrections (measured on them: median dE2000
#: 3.7, of it 1.6 in colour).
CORRECTED = Light(
    exposure=(0.0, 0.0),
    warmth=(0.0, 0.0),
    room_brightness=(0.12, 0.12),
    room_warmth=(0.0, 0.0),
    room_tint=0.035,
    surface=(0.0, 0.0),
    photo=(0.0, 0.0),
    code=0.0,
    next_room=0.0,
)
#: Photos in their own light. In two real development flats the log brightness of white walls is
#: -.9 and -1.5; the rooms of a flat differ by .13 and .32 in it, and by .04 and .30 in log red.
PHOTOS = Light(
    exposure=(-0.6, 0.45),
    warmth=(0.1, 0.15),
    room_brightness=(0.05, 0.35),
    room_warmth=(0.02, 0.35),
    room_tint=0.04,
    surface=(0.15, 0.03),
    photo=(0.15, 0.04),
    code=0.15,
    next_room=0.05,
)


def lit(graph: HouseGraph, rng: np.random.Generator, light: Light) -> tuple[np.ndarray, np.ndarray]:
    """Light a fully observed house; return its surfaces as photos show them, and as they look.

    Both are embeddings, (n, 3, 11) float32.
    """
    rooms, kinds = len(graph.room_ids), len(SURFACES)
    sides = rng.uniform(*np.transpose([light.room_brightness, light.room_warmth]))
    axes = rng.normal(*np.transpose([light.exposure, light.warmth])) + rng.normal(
        0.0, sides, (rooms, 1, 2)
    )
    axes = axes + rng.normal(0.0, light.surface, (rooms, kinds, 2))
    tint = rng.normal(0.0, light.room_tint, (rooms, 1, 2))
    colours = log_axes(srgb_to_linear(graph.embeddings[..., _COLOUR:]))
    truth = graph.embeddings.copy()
    truth[..., _COLOUR:] = _moved(colours, axes, tint)
    told = graph.embeddings.copy()
    axes = axes + rng.normal(0.0, light.photo, axes.shape)
    told[..., _COLOUR:] = _moved(colours, axes, tint)
    if light.code:
        noise = light.code * graph.embeddings[..., :_COLOUR].std(axis=(0, 1))
        told[..., :_COLOUR] += rng.normal(0.0, 1.0, told[..., :_COLOUR].shape) * noise
    wrong = np.nonzero(rng.random((rooms, kinds)) < light.next_room)
    for room, kind in zip(*wrong, strict=True):
        behind = graph.edges[1, graph.edges[0] == room]
        if len(behind):
            share = rng.uniform(0.3, 1.0)
            other = truth[rng.choice(behind), kind]
            told[room, kind] = (1.0 - share) * told[room, kind] + share * other
    return told, truth


def _moved(colours: np.ndarray, axes: np.ndarray, tint: np.ndarray) -> np.ndarray:
    """Return sRGB (n, 3, 3) of colours on log axes, shifted by brightness, warmth and tint.

    `axes` (n, 3, 2) is brightness and warmth.
    """
    shift = np.concatenate([axes[..., :1], axes[..., 1:2] * _WARMTH + tint], axis=-1)
    return linear_to_srgb(np.minimum(from_log_axes(colours + shift), 1.0))
