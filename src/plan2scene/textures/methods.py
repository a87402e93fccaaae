"""The texture methods: one registry for command line, configuration, workflow, stage and docs.

A method is an entry point of the group :data:`GROUP` that names a :class:`TextureMethod`. A maker
imports what it needs when it runs, so that listing the methods is cheap.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, TypeAlias

from plan2scene.errors import InputError
from plan2scene.plugins import plugins

if TYPE_CHECKING:
    from plan2scene.house import SurfaceKey
    from plan2scene.textures.inputs import TextureInputs
    from plan2scene.textures.tiles import NoTile, Tile

    #: Makes a tile for each surface of a house, or says why there is none.
    Maker: TypeAlias = Callable[[TextureInputs], Mapping[SurfaceKey, Tile | NoTile]]

GROUP = "plan2scene.texture_methods"  #: Entry points of this group name a :class:`TextureMethod`


@dataclass(frozen=True)
class TextureMethod:
    """How textures are made."""

    name: str  #: its name on the command line and in the configuration
    summary: str  #: what an observed surface gets, in words
    unobserved: str  #: what a surface gets that no visible photo shows, in words
    make: Maker  #: makes a tile for each surface of the inputs
    model: str | None = None  #: weight file that it decodes with: texture or naivesynth
    embedding: str | None = None  #: column of ``propagated.parquet`` that it needs
    library: bool = False  #: whether it may take tiles of the library
    crop_pool: bool = False  #: whether it may take crops of other houses
    seam_correction: bool = False  #: whether seams are corrected if the configuration does not say
    noise: bool = False  #: whether another seed gives another image (more images for FID and KID)
    fallback: str | None = None  #: name of the method for surfaces of which this one has no tile
    needs: str = ""  #: what pip has to install for it besides its own package's dependencies

    @property
    def weights(self) -> str | None:
        """Return the weight file of this method or of the one that it falls back on."""
        return self.model or (texture_methods()[self.fallback].weights if self.fallback else None)


def texture_methods() -> dict[str, TextureMethod]:
    """Return the methods of all installed packages by name."""
    return plugins(GROUP, TextureMethod)


def method_named(name: str) -> TextureMethod:
    """Return the method of a name; InputError if there is none."""
    methods = texture_methods()
    if name not in methods:
        raise InputError(f"a method of {', '.join(methods)}", name)
    return methods[name]


def _crop(inputs: TextureInputs) -> Mapping[SurfaceKey, Tile]:
    from plan2scene.textures.copying import crop_tiles

    return crop_tiles(inputs)


def _retrieve(inputs: TextureInputs) -> Mapping[SurfaceKey, Tile]:
    from plan2scene.textures.copying import retrieved_tiles

    return retrieved_tiles(inputs)


def _decoded(inputs: TextureInputs, model: str, column: str) -> Mapping[SurfaceKey, Tile]:
    from plan2scene.textures.decoding import decoded_tiles

    return decoded_tiles(inputs, model, column)


def _synth_large(inputs: TextureInputs) -> Mapping[SurfaceKey, Tile]:
    from plan2scene.textures.decoding import constrained_tiles

    return constrained_tiles(inputs, _decoded(inputs, "texture", "embedding"))


def _exemplar(inputs: TextureInputs) -> Mapping[SurfaceKey, Tile | NoTile]:
    from plan2scene.textures.exemplar.house_tiles import exemplar_tiles

    return exemplar_tiles(inputs)


def _medoid_colour(inputs: TextureInputs) -> Mapping[SurfaceKey, Tile]:
    from plan2scene.textures.copying import flat_tiles

    return flat_tiles(inputs)


def _projection(inputs: TextureInputs) -> Mapping[SurfaceKey, Tile]:
    from plan2scene.textures.copying import projected_tiles

    return projected_tiles(inputs)


CROP = TextureMethod(
    "crop",
    "its reference crop, the medoid",
    "a crop of another surface",
    _crop,
    library=True,
    crop_pool=True,
)
RETRIEVE = TextureMethod(
    "retrieve",
    "the tile nearest to its reference crop",
    "the tile nearest to a crop of another surface",
    _retrieve,
    library=True,
    crop_pool=True,
)
NAIVESYNTH = TextureMethod(
    "naivesynth",
    "decoded from the mean code of its crops by the unmodified model",
    "decoded from the mean of its room type",
    partial(_decoded, model="naivesynth", column="naive_embedding"),
    model="naivesynth",
    embedding="naive_embedding",
    seam_correction=True,
    noise=True,
)
SYNTH = TextureMethod(
    "synth",
    "decoded from the code of its best crop (the paper's)",
    "decoded from the propagated embedding",
    partial(_decoded, model="texture", column="embedding"),
    model="texture",
    embedding="embedding",
    seam_correction=True,
    noise=True,
)
SYNTH_LARGE = TextureMethod(
    "synth-large",
    "as synth, then with the colours and the spectrum of that crop",
    "as synth",
    _synth_large,
    model="texture",
    embedding="embedding",
    seam_correction=True,
)
EXEMPLAR = TextureMethod(
    "exemplar",
    "quilted from its crops; as synth where they are too poor",
    "the house's nearest exemplar of its substance, else a usual one; as synth where none is seen",
    _exemplar,
    seam_correction=True,
    fallback="synth",
)
MEDOID_COLOUR = TextureMethod(
    "medoid_colour",
    "the median colour of its reference crop (IM2CAD)",
    "the median colour of a crop of another surface",
    _medoid_colour,
    library=True,
    crop_pool=True,
)
PROJECTION = TextureMethod(
    "projection",
    "its largest crop, stretched over it (Rent3D)",
    "a crop of another surface, stretched over it",
    _projection,
    library=True,
    crop_pool=True,
)
