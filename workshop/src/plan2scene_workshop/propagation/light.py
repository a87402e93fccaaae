"""Light of training homes: what photos make of the colours of a house's surfaces.

A texture's code hardly depends on the light (its network sees colours relative to the crop's own),
so light acts on embeddings, drawn anew each time that a house is: the exposure and balance of the
house, the light of each room, shade on each surface. That is what a surface looks like in its own
room, which is to predict. What photos tell of it differs further: by the part that they show, by
noise in the code, and now and then a crop shows the next room's surface through a door.

Axes: log brightness, warmth (red up, blue down) and tint (red, blue) of linear colours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plan2scene.colour import from_log_axes, linear_to_srgb, log_axes, srgb_to_linear
from plan2scene.house import SURFACES
from plan2scene.propagation.graph import HouseGraph

#: First of the embedding's three colour values.
_COLOUR = 8
#: Log red and log blue, against green, of one unit of warmth (lamp light against daylight: the two
#: real development flats' rooms lie along this line, correlation -.9).
_WARMTH = np.array([1.0, -0.5])


@dataclass(frozen=True)
class Light:
    """Standard deviations of brightness and warmth; of a range each house has its own."""

    exposure: tuple[float, float]  #: mean and deviation of the houses' brightness
    warmth: tuple[float, float]  #: mean and deviation of the houses' warmth
    room_brightness: tuple[float, float]  #: range
    room_warmth: tuple[float, float]  #: range
    room_tint: float
    surface: tuple[float, float]  #: shade on a surface of a room
    photo: tuple[float, float]  #: what photos tell against what there is
    code: float  #: noise of the codes of what photos tell, of their deviation over surfaces
    next_room: float  #: chance that crops show the next room's surface, in part or in all


#: What the light corrections leave of the light of rendered photos (measured on them: median
#: dE2000 3.7, of it 1.6 in colour).
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
#: Photos in their own light. On two real development flats white walls lie at -.9 and -1.5 of log
#: brightness, the rooms of one .13 and .32 apart in it and .04 and .30 in red.
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
    """Return what photos tell of the surfaces of a fully observed house, and what they look like.

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
    """Return sRGB (n, 3, 3) of log colours under light: brightness and warmth (n, 3, 2), tint."""
    shift = np.concatenate([axes[..., :1], axes[..., 1:2] * _WARMTH + tint], axis=-1)
    return linear_to_srgb(np.minimum(from_log_axes(colours + shift), 1.0))
