"""One seamless tile from the crops of one surface: the texture stage without a house."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from plan2scene.seeds import derive_seed
from plan2scene.weights import MODELS

#: Side of the crops that the models were trained on.
CROP_PX = 128
#: Tiles of each substance in the library that method retrieve chooses from.
LIBRARY_TILES = 60


def square_crop(image: np.ndarray) -> np.ndarray:
    """Return the middle square of a (h, w, 3) uint8 sRGB image at 128x128 px."""
    import cv2

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
        ``crop`` (medoid crop, seam-corrected), ``retrieve`` (nearest procedural tile),
        ``naivesynth`` (decoded mean embedding), ``synth`` (decoded selected embedding),
        ``synth-large`` (then with the selected crop's statistics),
        ``exemplar`` (of the crops themselves; as ``synth`` where they are too poor).
        ValueError for another one.
    """
    import cv2

    from plan2scene.photos.crops.sampling import medoid_index
    from plan2scene.textures.seams import make_seamless

    crops = [square_crop(image) for image in images]
    if method == "exemplar":
        from plan2scene.textures.exemplar.make import ExemplarCrop, make_exemplar

        unknown = float("nan")
        known = [ExemplarCrop(crop, unknown, unknown) for crop in crops]
        made = make_exemplar(known, size_px=size_px)
        if made is not None:
            return made.image
        method = "synth"
    if method in ("synth", "synth-large", "naivesynth"):
        return _decoded(np.stack(crops), method, size_px, seed, models)
    reference = crops[medoid_index(crops)]
    if method == "retrieve":
        from plan2scene.textures.baselines.retrieval import generated_library

        library = generated_library(LIBRARY_TILES, seed, size_px)
        return make_seamless(library.tiles[library.nearest(reference)])[0]
    if method != "crop":
        raise ValueError(
            f"expected crop, retrieve, naivesynth, synth, synth-large or exemplar, found {method!r}"
        )
    if size_px != CROP_PX:
        reference = cv2.resize(reference, (size_px, size_px), interpolation=cv2.INTER_AREA)
    return make_seamless(reference)[0]


def _decoded(crops: np.ndarray, method: str, size_px: int, seed: int, models: Path) -> np.ndarray:
    """Return the tile that the texture model of a method decodes; periodic by construction."""
    from plan2scene.colour import clipped_share
    from plan2scene.textures.constrained import even_crop, match_statistics
    from plan2scene.textures.model.embedding import embed_crops
    from plan2scene.textures.model.network import load_texture_model
    from plan2scene.textures.model.synthesis import decode_textures
    from plan2scene.textures.seams import make_seamless
    from plan2scene.textures.selection import surface_embedding

    name = "naivesynth" if method == "naivesynth" else "texture"
    model = load_texture_model(models / f"{name}.safetensors")
    selected = method != "naivesynth"
    embeddings = embed_crops(model, crops, seed=seed, textureness=selected)
    if selected:
        clipped = np.array([clipped_share(crop) for crop in crops])
        best, code = surface_embedding(embeddings.codes, embeddings.textureness, clipped)
    else:
        code = embeddings.codes.mean(axis=0)
    tile = decode_textures(model, code[None], [derive_seed(seed, "tile", method)], size_px)[0]
    if method == "synth-large":
        even = even_crop(crops[best], list(np.delete(crops, best, axis=0)), code[-3:], size_px)
        tile = match_statistics(tile, even, derive_seed(seed, "statistics"))
    return tile if model.architecture.periodic else make_seamless(tile)[0]
