"""Light effects of quick training photos beyond diffuse light: flash, near lamps, reflections."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from plan2scene.photos.labels.palette import CEILING, WALL
from plan2scene_workshop.rendering.quick import Hits, Image, QuickTracer
from plan2scene_workshop.rendering.tracer import Finish
from plan2scene_workshop.rendering.views import View

#: Reflectance at normal incidence of metals, and of all other materials.
_METAL, _DIELECTRIC = 0.55, 0.05


def flash_light(view: View, hits: Hits, light: Image, rng: np.random.Generator) -> Image:
    """Return the light of a flash beside the lens, in an eighth of the photos."""
    if rng.random() > 0.12:
        return np.zeros_like(light)
    strength = float(np.median(light)) * float(np.exp(rng.uniform(0.5, 2.5)))
    return _point_light(np.array(view.position, np.float32), hits, 2 * strength, rng)


def lamp_light(tracer: QuickTracer, hits: Hits, light: Image, rng: np.random.Generator) -> Image:
    """Return the light of one or two lamps near a wall or ceiling, in a fifth of the photos.

    The surface is overexposed there, but its label does not change.
    """
    found = np.zeros_like(light)
    if rng.random() > 0.2:
        return found
    surface = (hits.face >= 0) & np.isin(tracer.faces.labels[hits.face], (WALL, CEILING))
    rows, columns = np.nonzero(surface)
    for _ in range(int(rng.integers(1, 3)) if len(rows) else 0):
        k = int(rng.integers(len(rows)))
        place = rows[k], columns[k]
        where = hits.position[place] + hits.normal[place] * rng.uniform(0.12, 0.5)
        strength = float(np.median(light)) * float(np.exp(rng.uniform(-1.5, 1.0)))
        found += _point_light(where.astype(np.float32), hits, strength, rng)
    return found


def _point_light(
    where: NDArray[np.float32], hits: Hits, strength: float, rng: np.random.Generator
) -> Image:
    """Return irradiance / pi (h, w, 3) of a point light without shadows."""
    ray = hits.position - where
    far = np.maximum(np.linalg.norm(ray, axis=-1), 0.1)
    facing = np.maximum(-(ray * hits.normal).sum(-1) / far, 0)
    colour = np.exp(rng.normal(0, 0.08, 3)).astype(np.float32)
    fall = np.where(hits.face >= 0, strength * facing / far**2, 0)
    return (fall[..., None] * colour).astype(np.float32)


def draw_gloss(
    names: Sequence[str], finishes: Sequence[Finish], rng: np.random.Generator
) -> NDArray[np.float32]:
    """Return (n, 2): reflectance at normal incidence and blur of the reflection of each finish.

    Blur is in pixels of a photo about 170 px wide. The reflectance of most finishes follows from
    their roughness; some models are polished at random.
    """
    rows = []
    for name, finish in zip(names, finishes, strict=True):
        blur = float(np.exp(rng.uniform(-0.5, 2.2)))
        strength = rng.uniform(0.4, 1.2) * np.clip((0.75 - finish.roughness) / 0.5, 0, 1)
        if name.startswith("model") and rng.random() < 0.35:
            strength = rng.uniform(0.2, 1.0)
        if rng.random() < 0.35 or finish.emission is not None:
            strength = 0.0
        if finish.metallic:
            strength = rng.uniform(0.5, 1.2)
        rows.append((strength * (_METAL if finish.metallic else _DIELECTRIC), blur))
    return np.array(rows, np.float32).reshape(-1, 2)


def reflections(
    tracer: QuickTracer,
    gloss: NDArray[np.float32],
    view: View,
    small: Hits,
    hits: Hits,
    light: Image,
) -> Image:
    """Return the light (h, w, 3) that glossy faces mirror, blurred as `gloss` says.

    Mirror rays are cast at the size of `small`. An emitter is seen with its radiance, any other
    face with its mean colour in the photo's median light. Gloss rises at grazing angles (Schlick
    1994).
    """
    seen = tracer.mirrored(view, small)
    grey = tracer.faces.colours[seen] * np.median(light, axis=(0, 1))
    mirrored = np.where((seen >= 0)[..., None], tracer.faces.emission[seen] + grey, 0)
    mirrored = np.minimum(mirrored, 30 * max(float(np.median(light)), 1e-6)).astype(np.float32)
    group = np.where(hits.face >= 0, tracer.faces.groups[hits.face], -1)
    small_group = np.where(small.face >= 0, tracer.faces.groups[small.face], -1)
    found = np.zeros((*hits.face.shape, 3), np.float32)
    for k in np.unique(group):
        if k < 0 or gloss[k, 0] <= 0:
            continue
        inside = (small_group == k).astype(np.float32)
        sigma = (0, 0), float(gloss[k, 1])
        weight = cv2.GaussianBlur(inside, *sigma)[..., None]
        blurred = cv2.GaussianBlur(mirrored * inside[..., None], *sigma) / np.maximum(weight, 1e-3)
        large = cv2.resize(blurred, found.shape[1::-1], interpolation=cv2.INTER_LINEAR)
        found[group == k] = large[group == k]
    ray = hits.position - np.array(view.position, np.float32)
    cosine = np.abs((ray * hits.normal).sum(-1)) / np.maximum(np.linalg.norm(ray, axis=-1), 1e-6)
    base = np.where(group >= 0, gloss[group, 0], 0)
    share = base + base.clip(0, _DIELECTRIC) / _DIELECTRIC * 0.7 * (1 - cosine.clip(0, 1)) ** 5
    return found * share[..., None].astype(np.float32)
