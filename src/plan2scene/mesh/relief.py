"""Normal maps of surfaces whose texture shows relief: joints, boards, pile.

What is darker than its surroundings counts as deeper, as gaps and the shade between fibres are; of
tiles what is narrow, light or dark: their joints. How steep it gets depends on the substance and
on how much the texture varies; the printed colours of a pattern can't be told from relief, so
slopes stay small.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import cv2
import numpy as np

from plan2scene.images import image_from_bytes, jpeg_bytes
from plan2scene.mesh.parts import MeshPart
from plan2scene.mesh.texture_files import TileTexture


@dataclass(frozen=True)
class ReliefSettings:
    """How steep relief gets: little, as a printed pattern cannot be told from relief."""

    slopes: Mapping[str, float] = field(  #: root mean square, by substance
        default_factory=lambda: {"tile": 0.10, "wood": 0.07, "carpet": 0.14, "plaster": 0.06}
    )
    px_per_m: float = 128.0  #: of a normal map, at most
    least_contrast: float = 0.012  #: root mean square of fine luma in [0, 1]: below, nothing shows
    whole_contrast: float = 0.05  #: from here on slopes are whole
    fine_m: float = 0.006  #: sigmas between which luma is fine
    coarse_m: float = 0.06
    steepest: float = 0.5  #: slope, so that no pixel glints
    quality: int = 85  #: of JPEG
    border_px: int = 24  #: around, at most: a normal map repeats where its texture does


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
    luma = small @ np.array([0.2126, 0.7152, 0.0722]) / 255.0
    fine = _fine(luma, size[0] / tile.sides_m[0], mode)
    contrast = float(fine.std())
    if contrast < SETTINGS.least_contrast:
        return None
    if tile.substance == "tile" and (fine**3).mean() > 0:  # joints are lighter than tiles, here
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
    """Return what of a luma (h, w) varies at the scales of joints and grain."""
    border = min(SETTINGS.border_px, *(side - 1 for side in luma.shape))
    grown = np.pad(luma, border, mode=mode)
    near, far = (
        cv2.GaussianBlur(grown, (0, 0), max(sigma * px_per_m, 0.5))
        for sigma in (SETTINGS.fine_m, SETTINGS.coarse_m)
    )
    return np.asarray((near - far)[border:-border, border:-border])
