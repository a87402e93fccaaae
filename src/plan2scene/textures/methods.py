"""Names of the texture methods, and the models that they decode with; imports nothing heavy."""

from __future__ import annotations

from collections.abc import Mapping

#: Methods of the texture stage, those of the paper's table first and in its order.
METHODS = (
    *("crop", "retrieve", "naivesynth", "synth", "synth-large", "exemplar"),
    *("medoid_colour", "projection"),
)
#: Which of the texture models a method decodes with; the others decode nothing.
DECODERS: Mapping[str, str] = {
    "naivesynth": "naivesynth",
    "synth": "texture",
    "synth-large": "texture",
    "exemplar": "texture",
}
#: Column of propagated.parquet that is decoded: noise drawn again gives more images of a surface.
EMBEDDING_COLUMNS: Mapping[str, str] = {"synth": "embedding", "naivesynth": "naive_embedding"}
