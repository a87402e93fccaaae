"""One seamless tile from the crops of one surface: the texture stage on a house of one surface."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path

import cv2
import numpy as np

from plan2scene.house import House, Room, SurfaceKey
from plan2scene.images import png_bytes
from plan2scene.textures.crops import Crop
from plan2scene.textures.inputs import (
    HouseData,
    HouseFiles,
    KnownSurface,
    TextureInputs,
    TextureSettings,
)
from plan2scene.textures.library import TextureLibrary, generated_library
from plan2scene.textures.methods import TextureMethod, method_named
from plan2scene.textures.tiles import NoTile
from plan2scene.weights import MODELS

#: Side of the crops that the models were trained on.
CROP_PX = 128
#: Number of tiles of each substance in the library from which the method `retrieve` chooses.
LIBRARY_TILES = 60
_KEY = SurfaceKey("room", "wall")


def square_crop(image: np.ndarray) -> np.ndarray:
    """Return the middle square of a (h, w, 3) uint8 sRGB image at 128x128 px."""
    side = min(image.shape[:2])
    top, left = (image.shape[0] - side) // 2, (image.shape[1] - side) // 2
    square = image[top : top + side, left : left + side]
    filter_ = cv2.INTER_AREA if side > CROP_PX else cv2.INTER_CUBIC
    return cv2.resize(square, (CROP_PX, CROP_PX), interpolation=filter_)


def tile_from_crops(
    images: Sequence[np.ndarray], method: str, *, size_px: int, seed: int, models: Path = MODELS
) -> np.ndarray:
    """Return a seamless tile (size, size, 3) uint8 sRGB of one surface.

    Parameters
    ----------
    images : non-empty sequence of (h, w, 3) uint8 sRGB
        Crops of the surface; their middle squares are used at 128 px.
    method : str
        A name in :mod:`plan2scene.textures.methods`; InputError for any other name.
    """
    crops = [square_crop(image) for image in images]
    chosen = method_named(method)
    settings = TextureSettings(seed, size_px)
    tile = chosen.make(_inputs(crops, chosen, settings, models))[_KEY]
    if isinstance(tile, NoTile):
        return tile_from_crops(
            crops, str(chosen.fallback), size_px=size_px, seed=seed, models=models
        )
    image = tile.image
    if len(image) != size_px:
        image = cv2.resize(image, (size_px, size_px), interpolation=cv2.INTER_AREA)
    return replace(tile, image=image).without_seams().image


class _OneSurface(HouseData):
    """A house of one unknown room, and a library of procedural tiles."""

    def __init__(self, settings: TextureSettings) -> None:
        super().__init__(HouseFiles("crops", Path(), Path()))
        self._settings = settings

    @cached_property
    def house(self) -> House:
        """A house of one room, a square of a metre."""
        outline = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
        return House(self.files.house_id, (Room(_KEY.room_id, ("Room",), (outline,), 1.0),), ())

    @cached_property
    def library(self) -> TextureLibrary:
        """Tiles of each substance."""
        return generated_library(LIBRARY_TILES, self._settings.seed, self._settings.size_px)


def _inputs(
    images: list[np.ndarray], method: TextureMethod, settings: TextureSettings, models: Path
) -> TextureInputs:
    """Return the inputs of a texture method; an embedding only if the method needs one."""
    nan = math.nan
    crops = tuple(Crop(str(k), _KEY, png_bytes(image), nan) for k, image in enumerate(images))
    paths = {name: models / f"{name}.safetensors" for name in ("texture", "naivesynth")}
    codes: dict[str, np.ndarray] = {}
    best = 0
    if method.embedding and method.model:
        best, codes[method.embedding] = _embedding(
            np.stack(images), paths[method.model], settings.seed
        )
    surface = KnownSurface(
        *(_KEY, True, 1.0, "plaster", crops[best].crop_id, nan),
        embedding=codes.get("embedding"),
        naive_embedding=codes.get("naive_embedding"),
    )
    return TextureInputs(_OneSurface(settings), (surface,), crops, paths, settings)


def _embedding(crops: np.ndarray, model: Path, seed: int) -> tuple[int, np.ndarray]:
    """Return the index of the crop that represents the surface, and the surface's embedding.

    A model with colour (`delta_hsv`) selects one crop. For another model, the embedding is the mean
    over all crops, and the index is 0.
    """
    from plan2scene.colour import clipped_share
    from plan2scene.textures.model.embedding import embed_crops
    from plan2scene.textures.model.texture_model import load_texture_model
    from plan2scene.textures.observed_surfaces import surface_embedding

    network = load_texture_model(model)
    selects = network.architecture.delta_hsv
    embeddings = embed_crops(network, crops, seed=seed, textureness=selects)
    if not selects:
        return 0, embeddings.codes.mean(axis=0)
    clipped = np.array([clipped_share(crop) for crop in crops])
    return surface_embedding(embeddings.codes, embeddings.textureness, clipped)
