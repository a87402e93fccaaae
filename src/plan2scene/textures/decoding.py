"""Tiles decoded from embeddings, as the methods synth and naivesynth make them.

Torch is imported only where something is decoded.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from plan2scene.errors import InputError
from plan2scene.house import SurfaceKey
from plan2scene.seeds import derive_seed
from plan2scene.textures.inputs import KnownSurface, TextureInputs
from plan2scene.textures.methods import TextureMethod, method_named
from plan2scene.textures.seams import make_seamless
from plan2scene.textures.tiles import Tile


def decoded_tiles(inputs: TextureInputs, name: str) -> Mapping[SurfaceKey, Tile]:
    """Return the tiles of method `name`; their noise derives from (seed, house, room, surface)."""
    if name not in inputs.decoded:
        surfaces = inputs.surfaces
        images, periodic = _decoded(inputs, method_named(name), surfaces, [()] * len(surfaces))
        inputs.decoded[name] = {
            surface.key: Tile(image, surface.size_m, surface.source, periodic)
            for surface, image in zip(surfaces, images, strict=True)
        }
    return inputs.decoded[name]


def further_images(
    inputs: TextureInputs, method: TextureMethod, keys: Sequence[SurfaceKey], count: int
) -> list[np.ndarray]:
    """Return `count` more images (size, size, 3) uint8 of each surface, one surface's together.

    FID needs more images than its features have dimensions, and a test split has fewer surfaces
    (the paper takes 24 seeds): these differ from the surface's tile in their noise only.
    """
    known = {surface.key: surface for surface in inputs.surfaces}
    places = [(known[key], (k,)) for key in keys for k in range(1, count + 1)]
    images, periodic = _decoded(inputs, method, [s for s, _ in places], [k for _, k in places])
    correct = inputs.settings.seam_correction.get(method.name, method.seam_correction)
    if correct and not periodic:
        return [make_seamless(image)[0] for image in images]
    return list(images)


def _decoded(
    inputs: TextureInputs,
    method: TextureMethod,
    surfaces: Sequence[KnownSurface],
    numbers: Sequence[tuple[int, ...]],
) -> tuple[np.ndarray, bool]:
    """Return an image (n, size, size, 3) uint8 of each surface, and whether they tile.

    `numbers` tells images of one surface apart: what their noise derives from besides its name.
    """
    from plan2scene.textures.model.network import load_texture_model
    from plan2scene.textures.model.synthesis import decode_textures

    size, house_id = inputs.settings.size_px, inputs.data.files.house_id
    if not surfaces:
        return np.zeros((0, size, size, 3), np.uint8), True
    model = load_texture_model(inputs.models[str(method.model)])
    codes = np.stack([getattr(surface, str(method.embedding)) for surface in surfaces])
    if codes.shape[1] != model.embedding_dim:
        raise InputError(
            f"{method.embedding} of length {model.embedding_dim}, the model's",
            str(codes.shape[1]),
            house=house_id,
        )
    seeds = [
        derive_seed(inputs.settings.seed, house_id, *surface.key, *number)
        for surface, number in zip(surfaces, numbers, strict=True)
    ]
    return decode_textures(model, codes, seeds, size), model.architecture.periodic
