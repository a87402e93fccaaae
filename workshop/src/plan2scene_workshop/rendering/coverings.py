"""Coverings of windows: blinds with slats or vanes, cloth blinds, and closed curtains.

They look large and even like a wall; their true label is other.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from plan2scene.plans.wall_sides import FaceOpening
from plan2scene_workshop.rendering.geometry import Colour, Geometry, Solid, box, merge, placement
from plan2scene_workshop.rendering.palette import FABRICS, Palette, linear, pick
from plan2scene_workshop.rendering.shell import WallFace

#: Least distance of a covering from the wall's other openings and ends, metres.
_CLEAR = 0.03


@dataclass(frozen=True)
class _Span:
    """The area of a covering in metres on the wall's face; z is the distance from the face."""

    left: float
    right: float
    low: float
    top: float
    z: float

    @property
    def width(self) -> float:
        return self.right - self.left


#: (span, generator) -> solid of the covering.
_Maker = Callable[[_Span, np.random.Generator], Solid]


def add_covering(
    geometry: Geometry,
    face: WallFace,
    hole: FaceOpening,
    palette: Palette,
    rng: np.random.Generator,
) -> None:
    """Cover a window, mostly all of it, by one of :data:`COVERINGS`; its label is other."""
    kind = str(rng.choice(list(COVERINGS), p=[0.45, 0.1, 0.15, 0.3]))
    make, cloth = COVERINGS[kind]
    span = _curtained(face, hole, rng) if kind == "curtains" else _blind(face, hole, rng)
    solid = make(span, rng).moved(face.frame(0))
    if cloth:
        material = str(rng.choice([*FABRICS, *["fabric"] * 6]))
        colour = pick(rng, palette.fabrics) if rng.random() < 0.5 else _pale(rng)
    else:
        material, colour = "paint", _pale(rng) if rng.random() < 0.7 else _wooden(rng)
    geometry.add(material, solid, colour=colour)


def _blind(face: WallFace, hole: FaceOpening, rng: np.random.Generator) -> _Span:
    """Return the span of a blind: in the reveal, or in front of the wall and a little wider."""
    drop = 1.0 if rng.random() < 0.65 else rng.uniform(0.5, 1.0)
    if rng.random() < 0.5:
        low = hole.top - (hole.top - hole.bottom - 0.01) * drop
        return _Span(hole.left + 0.01, hole.right - 0.01, low, hole.top, -0.5 * face.inset)
    left, right = _between(face, hole, *rng.uniform(0.02, 0.1, 2))
    top = min(hole.top + rng.uniform(0.03, 0.12), face.height - 0.02)
    low = max(0.02, hole.bottom - rng.uniform(0.0, 0.08))
    return _Span(left, right, top - (top - low) * drop, top, 0.05)


def _curtained(face: WallFace, hole: FaceOpening, rng: np.random.Generator) -> _Span:
    """Return the span of curtains, sometimes from the ceiling or much wider than the window."""
    wide = rng.random() < 0.35
    beside = rng.uniform(0.3, 2.5, 2) if wide else rng.uniform(0.08, 0.35, 2)
    left, right = _between(face, hole, *beside)
    ceiling = face.height - 0.02
    top = ceiling if rng.random() < 0.4 else min(ceiling, hole.top + rng.uniform(0.08, 0.3))
    short = rng.random() < 0.25 and hole.bottom > 0.3
    return _Span(left, right, hole.bottom - 0.15 if short else 0.03, top, 0.1)


def _between(face: WallFace, hole: FaceOpening, left: float, right: float) -> tuple[float, float]:
    """Return a window's sides, moved outwards at most to the next opening or the wall's end."""
    before = [o.right for o in face.openings if o.right <= hole.left]
    after = [o.left for o in face.openings if o.left >= hole.right]
    start = max(hole.left - left, max(before, default=0.0) + _CLEAR)
    end = min(hole.right + right, min(after, default=face.length) - _CLEAR)
    return min(start, hole.left), max(end, hole.right)


def _slats(span: _Span, rng: np.random.Generator) -> Solid:
    """Return a Venetian blind: slats, mostly closed, on tapes between two rails."""
    pitch = 0.025 if rng.random() < 0.5 else rng.uniform(0.04, 0.055)
    shut = rng.random() < 0.7
    angle = np.radians(rng.choice([-1, 1]) * (rng.uniform(50, 78) if shut else rng.uniform(0, 45)))
    deep = 0.56 * pitch
    slat = box((span.left, -0.0007, -deep), (span.right, 0.0007, deep))
    c, s = np.cos(angle), np.sin(angle)
    parts = []
    for y in np.arange(span.low + 0.03, span.top - 0.03, pitch):
        parts.append(slat.moved(_turned((0, float(y), span.z), c, s)))
    ends = ((span.low, span.low + 0.018), (span.top - 0.035, span.top))
    parts += [box((span.left, y, span.z - 0.02), (span.right, b, span.z + 0.02)) for y, b in ends]
    tape, front = 0.002 if pitch < 0.03 else 0.012, span.z + deep
    for x in np.linspace(span.left, span.right, max(2, round(span.width / 0.5)) + 2)[1:-1]:
        parts.append(box((x - tape, span.low, front), (x + tape, span.top, front + 0.001)))
    return merge(parts)


def _turned(at: tuple[float, float, float], c: float, s: float) -> np.ndarray:
    """Return the transform (4, 4) of a slat to a point, rotated about its length (cos c, sin s)."""
    x, y, z = at
    return np.array([[1, 0, 0, x], [0, c, -s, y], [0, s, c, z], [0, 0, 0, 1.0]])


def _vanes(span: _Span, rng: np.random.Generator) -> Solid:
    """Return a vertical blind: vanes side by side, all turned by the same angle."""
    wide = rng.uniform(0.085, 0.13)
    angle = np.radians(rng.choice([-1, 1]) * rng.uniform(8, 60))
    vane = box((-0.55 * wide, span.low, -0.0007), (0.55 * wide, span.top - 0.04, 0.0007))
    places = np.arange(span.left + 0.5 * wide, span.right - 0.3 * wide, wide)
    parts = [vane.moved(placement(float(x), span.z, float(angle))) for x in places]
    rail = box((span.left, span.top - 0.04, span.z - 0.02), (span.right, span.top, span.z + 0.02))
    return merge([*parts, rail])


def _sheet(span: _Span, rng: np.random.Generator) -> Solid:
    """Return a roller blind, or a Roman blind with folds."""
    parts = [box((span.left, span.low, span.z - 0.002), (span.right, span.top, span.z + 0.002))]
    if rng.random() < 0.3:
        for y in np.arange(span.low, span.top - 0.1, rng.uniform(0.15, 0.3)):
            parts.append(box((span.left, y, span.z), (span.right, y + 0.02, span.z + 0.012)))
    return merge(parts)


def _curtains(span: _Span, rng: np.random.Generator) -> Solid:
    """Return two drawn curtains that meet, nearly meet, or leave a gap."""
    gap = float(rng.choice([-0.06, 0.0, rng.uniform(0.0, 0.2)])) * span.width
    middle = span.left + span.width * rng.uniform(0.4, 0.6)
    fold = rng.uniform(0.06, 0.18)
    sheets = (span.left, middle - gap / 2), (middle + gap / 2, span.right)
    return merge([wavy_sheet(a, b, span.low, span.top, fold) for a, b in sheets])


def wavy_sheet(low: float, high: float, bottom: float, top: float, fold: float) -> Solid:
    """Return a hanging cloth from x `low` to `high`, seen from both sides."""
    columns = max(12, int((high - low) / fold * 8))
    x = np.linspace(low, high, columns + 1)
    phase = 2 * np.pi * (x - low) / fold
    z = 0.1 + 0.035 * np.sin(phase)
    slope = 0.035 * 2 * np.pi / fold * np.cos(phase)
    normal = np.stack([-slope, np.zeros_like(x), np.ones_like(x)], -1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    vertices = np.concatenate([np.stack([x, np.full_like(x, y), z], -1) for y in (top, bottom)])
    along = np.concatenate([[0], np.cumsum(np.hypot(np.diff(x), np.diff(z)))])
    uv = np.concatenate([np.stack([along, np.full_like(x, v)], -1) for v in (0.0, top - bottom)])
    i = np.arange(columns)
    a, b, c, d = i, i + 1, i + columns + 2, i + columns + 1
    faces = np.concatenate([np.stack([a, c, b], -1), np.stack([a, d, c], -1)])
    front = Solid(vertices, np.tile(normal, (2, 1)), uv, faces)
    back_vertices = vertices - np.tile(normal, (2, 1)) * 0.003
    back = Solid(back_vertices, -np.tile(normal, (2, 1)), uv, faces[:, ::-1])
    return merge([front, back])


def _pale(rng: np.random.Generator) -> Colour:
    """Return white, cream or grey, like the colours of walls."""
    return linear(rng.uniform(0.05, 0.2), rng.uniform(0, 0.25), rng.uniform(0.45, 0.95))


def _wooden(rng: np.random.Generator) -> Colour:
    return linear(rng.uniform(0.04, 0.1), rng.uniform(0.35, 0.7), rng.uniform(0.15, 0.7))


#: Coverings of windows: their maker, and whether they are of cloth.
COVERINGS: dict[str, tuple[_Maker, bool]] = {
    "slats": (_slats, False),
    "vanes": (_vanes, False),
    "sheet": (_sheet, True),
    "curtains": (_curtains, True),
}
