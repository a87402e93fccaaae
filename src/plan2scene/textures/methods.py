"""The texture methods: one registry for command line, configuration, workflow, stage and docs.

A new method is a maker with a :func:`register`. A maker imports what it needs when it runs, so that
the names cost nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

from plan2scene.errors import InputError

if TYPE_CHECKING:
    from plan2scene.house import SurfaceKey
    from plan2scene.textures.inputs import TextureInputs
    from plan2scene.textures.tiles import NoTile, Tile

    #: Makes the tiles of a house's surfaces, or says why there is none of one.
    Maker: TypeAlias = Callable[[TextureInputs], Mapping[SurfaceKey, Tile | NoTile]]


_Maker = TypeVar("_Maker", bound="Maker")


@dataclass(frozen=True)
class TextureMethod:
    """How textures are made.

    Attributes
    ----------
    name : str
        As command line and configuration have it.
    summary : str
        What an observed surface gets, for people.
    unobserved : str
        What a surface gets that no visible photo shows.
    make : callable
        Makes a tile for each surface of :class:`~plan2scene.textures.inputs.TextureInputs`.
    model : str, optional
        Weight file that it decodes with (``texture`` or ``naivesynth``).
    embedding : str, optional
        Column of ``propagated.parquet`` that it cannot do without.
    library, crop_pool : bool
        Whether it may take tiles of the library, and crops of other houses.
    seam_correction : bool
        Whether what does not tile by construction is corrected where the configuration is silent.
    noise : bool
        Whether another seed gives another image of a surface (more images for FID and KID).
    fallback : str, optional
        The method that makes the surfaces of which this one has no tile.
    """

    name: str
    summary: str
    unobserved: str
    make: Maker
    model: str | None = None
    embedding: str | None = None
    library: bool = False
    crop_pool: bool = False
    seam_correction: bool = False
    noise: bool = False
    fallback: str | None = None

    @property
    def weights(self) -> str | None:
        """Return the weight file of this method or of the one that it falls back on."""
        return self.model or (METHODS[self.fallback].weights if self.fallback else None)


#: The methods by name, those of the paper's table first and in its order.
METHODS: dict[str, TextureMethod] = {}


def register(name: str, summary: str, unobserved: str, **needs: Any) -> Callable[[_Maker], _Maker]:
    """Return a decorator that registers a maker as a method; arguments of TextureMethod.

    ValueError where the name is taken.
    """

    def registered(make: _Maker) -> _Maker:
        if name in METHODS:
            raise ValueError(f"expected a new name, found method {name} twice")
        METHODS[name] = TextureMethod(name, summary, unobserved, make, **needs)
        return make

    return registered


def method_named(name: str) -> TextureMethod:
    """Return a method; InputError for a name that is none."""
    if name not in METHODS:
        raise InputError(f"a method of {', '.join(METHODS)}", name)
    return METHODS[name]


def methods_table() -> str:
    """Return the methods as a Markdown table."""
    head = ("method", "observed surface", "other surface", "needs", "seams", "FID seeds")
    rows: list[tuple[str, ...]] = [head, ("---",) * len(head)]
    for method in METHODS.values():
        needs = [f"{method.weights} weights"] * bool(method.weights)
        needs += ["tile library"] * method.library + ["crop pool"] * method.crop_pool
        seams = "corrected" if method.seam_correction else "left"
        more = "more" if method.noise else "one"
        text = (method.summary, method.unobserved, ", ".join(needs) or "crops", seams, more)
        rows.append((f"`{method.name}`", *text))
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)


_COPIED = {"library": True, "crop_pool": True}


@register("crop", "its reference crop, the medoid", "a crop of another surface", **_COPIED)
def _crop(inputs: TextureInputs) -> Mapping[SurfaceKey, Tile]:
    from plan2scene.textures.baselines.copying import crop_tiles

    return crop_tiles(inputs)


@register(
    "retrieve",
    "the tile nearest to its reference crop",
    "the tile nearest to a crop of another surface",
    **_COPIED,
)
def _retrieve(inputs: TextureInputs) -> Mapping[SurfaceKey, Tile]:
    from plan2scene.textures.baselines.copying import retrieved_tiles

    return retrieved_tiles(inputs)


@register(
    "naivesynth",
    "decoded from the mean code of its crops by the unmodified model",
    "decoded from the mean of its room type",
    model="naivesynth",
    embedding="naive_embedding",
    seam_correction=True,
    noise=True,
)
def _naivesynth(inputs: TextureInputs) -> Mapping[SurfaceKey, Tile]:
    from plan2scene.textures.decoding import decoded_tiles

    return decoded_tiles(inputs, "naivesynth")


@register(
    "synth",
    "decoded from the code of its best crop (the paper's)",
    "decoded from the propagated embedding",
    model="texture",
    embedding="embedding",
    seam_correction=True,
    noise=True,
)
def _synth(inputs: TextureInputs) -> Mapping[SurfaceKey, Tile]:
    from plan2scene.textures.decoding import decoded_tiles

    return decoded_tiles(inputs, "synth")


@register(
    "synth-large",
    "as synth, then with the colours and the spectrum of that crop",
    "as synth",
    model="texture",
    embedding="embedding",
    seam_correction=True,
)
def _synth_large(inputs: TextureInputs) -> Mapping[SurfaceKey, Tile]:
    from plan2scene.textures.constrained import constrained_tiles

    return constrained_tiles(inputs, _synth(inputs))


@register(
    "exemplar",
    "quilted from its crops; as synth where they are too poor",
    "the house's nearest exemplar of its substance, else a usual one; as synth where none is seen",
    seam_correction=True,
    fallback="synth",
)
def _exemplar(inputs: TextureInputs) -> Mapping[SurfaceKey, Tile | NoTile]:
    from plan2scene.textures.exemplar.house import exemplar_tiles

    return exemplar_tiles(inputs)


@register(
    "medoid_colour",
    "the median colour of its reference crop (IM2CAD)",
    "the median colour of a crop of another surface",
    **_COPIED,
)
def _medoid_colour(inputs: TextureInputs) -> Mapping[SurfaceKey, Tile]:
    from plan2scene.textures.baselines.copying import flat_tiles

    return flat_tiles(inputs)


@register(
    "projection",
    "its largest crop, stretched over it (Rent3D)",
    "a crop of another surface, stretched over it",
    **_COPIED,
)
def _projection(inputs: TextureInputs) -> Mapping[SurfaceKey, Tile]:
    from plan2scene.textures.baselines.copying import projected_tiles

    return projected_tiles(inputs)
