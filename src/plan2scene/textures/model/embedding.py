"""Embeddings of crops: code and median colour, substance, and how texture-like each crop is."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch

from plan2scene.house import SUBSTANCES
from plan2scene.images import image_from_bytes
from plan2scene.io import read_parquet, write_parquet
from plan2scene.propagation.substances import on_surfaces
from plan2scene.provenance import file_hash
from plan2scene.seeds import derive_seed
from plan2scene.textures.model.statistics import FilterBankStatistics, gram_distance, grams_of
from plan2scene.textures.model.texture_model import (
    StatisticsEncoder,
    TextureModel,
    fast_decoding,
    load_texture_model,
    noise_seeds,
)

_BATCH = 4  #: Crops at a time: so few that their responses stay in the processor's cache
#: Rows, and columns, of a texture that are decoded for its score: a quarter of the work, and enough
#: because a texture looks alike everywhere.
_SCORED = slice(0, 64)
_LEVELS = 3  #: Pyramid levels of the score, as many as that part has


@dataclass(frozen=True, eq=False)
class Embeddings:
    """The outputs of the texture model for n crops, float32."""

    codes: np.ndarray  #: (n, 11): bottleneck 8 and median R, G, B in [0, 1]; (n, 8): the code alone
    substance_probabilities: np.ndarray  #: (n, 4) in the order of SUBSTANCES; (n, 0) without a head
    textureness: np.ndarray  #: (n,) score of :func:`embed_crops`, less is better; may be empty
    naive_codes: np.ndarray  #: (n, 8) of the second model; empty when there is none


def embed_crops(
    model: TextureModel,
    crops: np.ndarray,
    *,
    seed: int = 0,
    textureness: bool = True,
    naive: TextureModel | None = None,
    threads: int = 1,
) -> Embeddings:
    """Return the embeddings of crops (n, 128, 128, 3) uint8.

    With `textureness` each crop's embedding is decoded, with the same noise of `seed`. Its score is
    the distance between the texture statistics of the crop and of the decoded texture (paper
    section 5.3). `naive` is a second model that also encodes the crops. `threads` batches are
    processed at a time; the result does not depend on it.
    """
    models = [model] if naive is None else [model, naive]
    filters, scored = FilterBankStatistics(), FilterBankStatistics(_LEVELS)
    noise = noise_seeds([seed])

    def embed(part: np.ndarray) -> tuple[np.ndarray | None, ...]:
        rgb = torch.from_numpy(part).permute(0, 3, 1, 2).float() / 255.0
        with torch.inference_mode():
            # Both models and the score see the crops through the same filters.
            responses = list(filters.responses(rgb))
            features = _features(models, rgb, responses)
            encoding, *others = (each.encode(rgb, features) for each in models)
            odds = None if encoding.logits is None else encoding.logits.softmax(1).numpy()
            score = None
            if textureness:
                tiles = model.decode(
                    encoding.embedding, noise.expand(len(rgb), -1, -1), window=(_SCORED, _SCORED)
                )
                score = gram_distance(scored.grams(tiles), grams_of(responses[:_LEVELS])).numpy()
        plain = others[0].embedding.numpy() if others else None
        return encoding.embedding.numpy(), odds, score, plain

    batches = [crops[start : start + _BATCH] for start in range(0, len(crops), _BATCH)]
    with fast_decoding(model), ThreadPoolExecutor(threads) as pool:
        by_batch = list(pool.map(embed, batches))
    codes, probabilities, scores, plain = (
        ([part for part in parts if part is not None] for parts in zip(*by_batch, strict=True))
        if by_batch
        else ([], [], [], [])
    )
    return Embeddings(
        _stack(codes, (0, model.embedding_dim)),
        _stack(probabilities, (len(crops), 0) if len(crops) else (0, len(SUBSTANCES))),
        _stack(scores, (0,)),
        _stack(plain, (0, 0 if naive is None else naive.embedding_dim)),
    )


def _features(
    models: Sequence[TextureModel], rgb: torch.Tensor, responses: Sequence[torch.Tensor]
) -> torch.Tensor | None:
    """Return the crops' features for statistics encoders; None if no model has such an encoder."""
    for model in models:
        if isinstance(model.encoder, StatisticsEncoder):
            return model.encoder.features(rgb, responses)
    return None


def _stack(parts: list[np.ndarray], empty: tuple[int, ...]) -> np.ndarray:
    """Return arrays joined along the first axis; an array of shape `empty` if there are none."""
    return np.concatenate(parts) if parts else np.zeros(empty, dtype=np.float32)


def make_embeddings(
    crops_parquet: str | Path,
    output: str | Path,
    texture_model: str | Path,
    naive_model: str | Path,
    *,
    house: str,
    dataset: str,
    seed: int,
    threads: int = 1,
) -> None:
    """Write ``embeddings.parquet`` of a house (docs/conventions.md): a row per row of crops.

    A crop that shows several rooms is embedded once. A house without crops gets an empty table.
    """
    import pandas as pd

    table, _ = read_parquet(crops_parquet)
    distinct = table.drop_duplicates("crop_id")
    images = [image_from_bytes(data) for data in distinct["png"]]
    crops = np.stack(images) if images else np.zeros((0, 128, 128, 3), dtype=np.uint8)
    embeddings = embed_crops(
        load_texture_model(texture_model),
        crops,
        seed=derive_seed(seed, "textureness"),
        naive=load_texture_model(naive_model),
        threads=threads,
    )
    row_of = {crop_id: row for row, crop_id in enumerate(distinct["crop_id"])}
    rows = [row_of[crop_id] for crop_id in table["crop_id"]]
    substances = on_surfaces(embeddings.substance_probabilities[rows], list(table["surface"]))
    best = substances.argmax(1) if rows else np.zeros(0, dtype=int)
    frame = pd.DataFrame(
        {
            **{name: table[name] for name in ("crop_id", "photo", "room_id", "surface")},
            "embedding": pd.Series([embeddings.codes[i] for i in rows], dtype=object),
            "naive_embedding": pd.Series([embeddings.naive_codes[i] for i in rows], dtype=object),
            "substance": pd.Series([SUBSTANCES[i] for i in best], dtype=object),
            "substance_probabilities": pd.Series(list(substances), dtype=object),
            "textureness": np.array([embeddings.textureness[i] for i in rows], dtype=np.float64),
        }
    )
    metadata = {
        "dataset": dataset,
        "house": house,
        "model": file_hash(texture_model),
        "naive_model": file_hash(naive_model),
    }
    write_parquet(output, frame, metadata)
