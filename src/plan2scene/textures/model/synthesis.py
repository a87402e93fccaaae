"""Textures from embeddings: what the methods synth and naivesynth put on surfaces."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch

from plan2scene.textures.model.network import TextureModel, fast_decoding
from plan2scene.textures.model.noise import CHANNELS, OCTAVES

#: Textures decoded at once hold about this many pixels (bounds memory at any size).
_PIXELS = 4 * 128 * 128


def noise_seeds(seeds: Sequence[int]) -> torch.Tensor:
    """Return noise seeds (n, 8, 3) float32 in [0, 1) for integer seeds, each on its own."""
    draws = [np.random.default_rng(s).random((OCTAVES, CHANNELS), dtype=np.float32) for s in seeds]
    return torch.from_numpy(np.stack(draws))


def decode_textures(
    model: TextureModel, codes: np.ndarray, seeds: Sequence[int], size_px: int = 128
) -> np.ndarray:
    """Return tiles (n, size, size, 3) uint8 sRGB of embeddings; same code and seed, same tile.

    Parameters
    ----------
    codes : (n, d) float
        Embeddings of the model's length d; colours are clamped to [0, 1].
    seeds : n int
        Each decides the noise of one tile.
    size_px : int
        Side of the tiles. A larger one draws the same tile with more pixels.

    Processors without fast bfloat16 multiply in float32: their tiles differ by a level here and
    there (docs/conventions.md: same seed, same bytes).
    """
    if codes.ndim != 2 or codes.shape[1] != model.embedding_dim or len(codes) != len(seeds):
        raise ValueError(
            f"expected codes ({len(seeds)}, {model.embedding_dim}), found {codes.shape}"
        )
    values = torch.from_numpy(np.asarray(codes, dtype=np.float32).copy())
    code_dim = model.architecture.code_dim
    values[:, code_dim:] = values[:, code_dim:].clamp(0.0, 1.0)
    tiles = np.empty((len(codes), size_px, size_px, 3), dtype=np.uint8)
    step = max(1, _PIXELS // size_px**2)
    with torch.inference_mode(), fast_decoding(model):
        for start in range(0, len(codes), step):
            part = slice(start, start + step)
            rgb = model.decode(values[part], noise_seeds(seeds[part]), size_px)
            pixels = (rgb.clamp(0.0, 1.0) * 255.0).round().to(torch.uint8)
            tiles[part] = pixels.permute(0, 2, 3, 1).numpy()
    return tiles
