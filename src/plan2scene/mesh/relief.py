"""Normal maps of surfaces whose texture shows relief: joints, boards, pile.

Pixels darker than their surroundings count as deeper: gaps, and the shade between fibres. On tiles
the narrow structures count as deeper, light or dark: they are joints. Slopes depend on the
substance and on the contrast of the texture. They stay small, because a printed pattern cannot be
told from relief.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import cv2
import numpy as np

from plan2scene.colour import LUMINANCE
from plan2scene.images import image_from_bytes, jpeg_bytes
from plan2scene.mesh.parts import MeshPart
from plan2scene.mesh.texture_files import TileTexture


@dataclass(frozen=True)
class ReliefSettings:
    """How steep relief gets, and the size of normal maps."""

    slopes: Mapping[str, float] = field(  #: root mean square, by substance
        default_factory=lambda: {"tile": 0.10, "wood": 0.07, "carpet": 0.14, "plaster": 0.06}
    )
    px_per_m: float = 128.0  #: largest resolution of a normal map
    least_contrast: float = 0.012  #: no map if the deviation of fine luma in [0, 1] is smaller
    whole_contrast: float = 0.05  #: below this deviation slopes are reduced in proportion
    fine_m: float = 0.006  #: fine luma is a difference of Gaussians of sigmas `fine_m`, `coarse_m`
    coarse_m: float = 0.06
    steepest: float = 0.5  #: largest slope, so that no pixel glints
    quality: int = 85  #: of JPEG
    border_px: int = 24  #: largest padding before the blur: a repeating texture is wrapped


SETTINGS = ReliefSettings()


_Border = Literal["wrap", "reflect"]


def normal_map(tile: TileTexture) -> bytes | None:
    """Return a texture's normal map as JPEG; None where no relief shows.

    It covers what the texture covers. Tangent space of glTF: x along the image's rows to the
    right, y up the image, z off the surface.
    """
    strength = SETTINGS.slopes.get(tile.substance or "", 0.0)
    if not strength:
        return None
    image = image_from_bytes(tile.image)
    scale = min(1.0, SETTINGS.px_per_m * tile.sides_m[0] / image.shape[1])
    size = [max(4, round(side * scale)) for side in image.shape[1::-1]]
    small = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    mode: _Border = "reflect" if tile.jpeg else "wrap"
    luma = small @ LUMINANCE / 255.0
    fine = _fine(luma, size[0] / tile.sides_m[0], mode)
    contrast = float(fine.std())
    if contrast < SETTINGS.least_contrast:
        return None
    if tile.substance == "tile" and (fine**3).mean() > 0:  # here joints are lighter than tiles
        fine = -fine
    beyond = np.pad(fine, 1, mode=mode)
    down = (beyond[2:, 1:-1] - beyond[:-2, 1:-1]) / 2
    right = (beyond[1:-1, 2:] - beyond[1:-1, :-2]) / 2
    steep = float(np.sqrt((down**2 + right**2).mean()))
    share = min(contrast / SETTINGS.whole_contrast, 1.0)
    slopes = np.stack([-right, down], axis=-1) * (strength * share / max(steep, 1e-9))
    slopes = np.clip(slopes, -SETTINGS.steepest, SETTINGS.steepest)
    normals = np.dstack([slopes, np.ones(fine.shape)])
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    coded = np.round(127.5 + 127.5 * normals).astype(np.uint8)
    return jpeg_bytes(coded, quality=SETTINGS.quality, full_colour=True)


def tangents(part: MeshPart) -> np.ndarray:
    """Return the tangents (n, 4) float32 of a flat part with texture coordinates, as glTF's.

    The first three point along the image's rows; cross(normal, tangent) times the last (1 or -1)
    points up the image.
    """
    to_world = part.uv_to_world()
    normals = part.mesh.vertex_normals
    along = to_world[0] - normals * (normals @ to_world[0])[:, None]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    up = np.sign(np.cross(normals, along) @ -to_world[1])
    return np.column_stack([along, up]).astype(np.float32)


def _fine(luma: np.ndarray, px_per_m: float, mode: _Border) -> np.ndarray:
    """Return the part of a luma (h, w) that varies at the scales of joints and grain."""
    border = min(SETTINGS.border_px, *(side - 1 for side in luma.shape))
    grown = np.pad(luma, border, mode=mode)
    near, far = (
        cv2.GaussianBlur(grown, (0, 0), max(sigma * px_per_m, 0.5))
        for sigma in (SETTINGS.fine_m, SETTINGS.coarse_m)
    )
    return np.asarray((near - far)[border:-border, border:-border])
