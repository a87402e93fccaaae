"""A texture atlas: tiles of many sizes with mip levels in one array, for the renderer's kernels."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

#: Number of mip levels of each tile; the smallest is used for all larger distances.
LEVELS = 8


class Atlas:
    """Repeated tiles (h, w, 3) uint8 sRGB, interpolated bilinearly within one mip level."""

    def __init__(self, tiles: Sequence[NDArray[np.uint8] | None], mi: Any) -> None:
        self._mi = mi
        self._dr = importlib.import_module("drjit")
        numbers: dict[int, int] = {}
        self._of_group = np.full(len(tiles), -1, np.int32)
        starts, heights, widths, texels, at = [], [], [], [], 0
        for index, tile in enumerate(tiles):
            if tile is None:
                continue
            if id(tile) not in numbers:
                numbers[id(tile)] = len(numbers)
                for level in _mip_levels(tile):
                    starts.append(at)
                    heights.append(level.shape[0])
                    widths.append(level.shape[1])
                    texels.append(_packed(level))
                    at += texels[-1].size
            self._of_group[index] = numbers[id(tile)]
        self._texels = mi.UInt32(np.concatenate(texels or [np.zeros(1, np.uint32)]))
        self._starts = mi.Int32(np.array(starts or [0], np.int32))
        self._heights = mi.Int32(np.array(heights or [1], np.int32))
        self._widths = mi.Int32(np.array(widths or [1], np.int32))

    def tile_of(self, groups: NDArray[np.int32]) -> NDArray[np.int32]:
        """Return the tile number of each group index (m,); -1 for groups without a tile."""
        return self._of_group[groups]

    def lookup(self, tile: Any, uv: Any, footprint: Any, active: Any) -> Any:
        """Return linear colours at `uv` (v down); `footprint` is a sample's side; both in tiles."""
        mi, dr = self._mi, self._dr
        first = dr.select(active, tile, 0) * LEVELS
        side = mi.Float(dr.gather(mi.Int32, self._heights, first, active))
        level = mi.Int32(dr.clip(dr.log2(dr.maximum(footprint * side, 1e-6)), 0, LEVELS - 1))
        row = first + level
        start = dr.gather(mi.Int32, self._starts, row, active)
        height = dr.gather(mi.Int32, self._heights, row, active)
        width = dr.gather(mi.Int32, self._widths, row, active)
        x = (uv.x - dr.floor(uv.x)) * mi.Float(width) - 0.5
        y = (uv.y - dr.floor(uv.y)) * mi.Float(height) - 0.5
        x0, y0 = dr.floor(x), dr.floor(y)
        fx, fy = x - x0, y - y0
        colour = mi.Color3f(0)
        for dy, wy in ((0, 1 - fy), (1, fy)):
            i = mi.Int32(y0) + dy
            i = dr.select(i < 0, i + height, dr.select(i >= height, i - height, i))
            for dx, wx in ((0, 1 - fx), (1, fx)):
                j = mi.Int32(x0) + dx
                j = dr.select(j < 0, j + width, dr.select(j >= width, j - width, j))
                texel = dr.gather(mi.UInt32, self._texels, start + i * width + j, active)
                colour += (wx * wy) * self._unpacked(texel)
        return colour

    def _unpacked(self, texel: Any) -> Any:
        """Return the linear colour of packed sRGB bytes (a cubic close to the curve)."""
        mi = self._mi
        s = mi.Color3f(
            mi.Float(texel & 255), mi.Float((texel >> 8) & 255), mi.Float((texel >> 16) & 255)
        ) * (1 / 255)
        return s * (s * (s * 0.305306011 + 0.682171111) + 0.012522878)


def _mip_levels(tile: NDArray[np.uint8]) -> list[NDArray[np.uint8]]:
    levels = [tile]
    for _ in range(LEVELS - 1):
        height, width = levels[-1].shape[:2]
        size = (max(1, width // 2), max(1, height // 2))
        levels.append(cv2.resize(levels[-1], size, interpolation=cv2.INTER_AREA))
    return levels


def _packed(tile: NDArray[np.uint8]) -> NDArray[np.uint32]:
    """Return (h * w,) uint32 of (h, w, 3) bytes, with red in the lowest byte."""
    wide = tile.astype(np.uint32)
    packed = wide[..., 0] | wide[..., 1] << 8 | wide[..., 2] << 16
    return packed.astype(np.uint32).ravel()
