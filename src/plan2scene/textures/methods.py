"""The texture methods: one registry for command line, configuration, workflow, stage and docs.

A new method is a maker and one :func:`register`. A maker imports what it needs when it runs, so
that the names cost nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from plan2scene.errors import InputError

if TYPE_CHECKING:
    from plan2scene.house import SurfaceKey
    from plan2scene.textures.inputs import TextureInputs
    from plan2scene.textures.tiles import NoTile, Tile

    #: Makes the tiles of a house's surfaces, or says why there is none of one.
    Maker: TypeAlias = Callable[[TextureInputs], Mapping[SurfaceKey, Tile | NoTile]]


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


def register(method: TextureMethod) -> None:
    """Add a method; ValueError where its name is taken."""
    if method.name in METHODS:
        raise ValueError(f"expected a new name, found method {method.name} twice")
    METHODS[method.name] = method


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


def _crop(inputs: TextureInputs) -> Mapping[SurfaceKey, Tile]:
    from plan2scene.textures.baselines.copying import crop_tiles

    return crop_tiles(inputs)


def _retrieve(inputs: TextureInputs) -> Mapping[SurfaceKey, Tile]:
    from plan2scene.textures.baselines.copying import retrieved_tiles

    return retrieved_tiles(inputs)


def _medoid_colour(inputs: TextureInputs) -> Mapping[SurfaceKey, Tile]:
    from plan2scene.textures.baselines.copying import flat_tiles

    return flat_tiles(inputs)


def _projection(inputs: TextureInputs) -> Mapping[SurfaceKey, Tile]:
    from plan2scene.textures.baselines.copying import projected_tiles

    return projected_tiles(inputs)


def _naivesynth(inputs: TextureInputs) -> Mapping[SurfaceKey, Tile]:
    from plan2scene.textures.decoding import decoded_tiles

    return decoded_tiles(inputs, METHODS["naivesynth"])


def _synth(inputs: TextureInputs) -> Mapping[SurfaceKey, Tile]:
    from plan2scene.textures.decoding import decoded_tiles

    return decoded_tiles(inputs, METHODS["synth"])


def _synth_large(inputs: TextureInputs) -> Mapping[SurfaceKey, Tile]:
    from plan2scene.textures.constrained import constrained_tiles
    from plan2scene.textures.decoding import decoded_tiles

    return constrained_tiles(inputs, decoded_tiles(inputs, METHODS["synth"]))


def _exemplar(inputs: TextureInputs) -> Mapping[SurfaceKey, Tile | NoTile]:
    from plan2scene.textures.exemplar.house import exemplar_tiles

    return exemplar_tiles(inputs)


register(
    TextureMethod(
        "crop",
        "its reference crop, the medoid",
        "a crop of another surface",
        _crop,
        library=True,
        crop_pool=True,
    )
)
register(
    TextureMethod(
        "retrieve",
        "the tile nearest to its reference crop",
        "the tile nearest to a crop of another surface",
        _retrieve,
        library=True,
        crop_pool=True,
    )
)
register(
    TextureMethod(
        "naivesynth",
        "decoded from the mean code of its crops by the unmodified model",
        "decoded from the mean of its room type",
        _naivesynth,
        model="naivesynth",
        embedding="naive_embedding",
        seam_correction=True,
        noise=True,
    )
)
register(
    TextureMethod(
        "synth",
        "decoded from the code of its best crop (the paper's)",
        "decoded from the propagated embedding",
        _synth,
        model="texture",
        embedding="embedding",
        seam_correction=True,
        noise=True,
    )
)
register(
    TextureMethod(
        "synth-large",
        "as synth, then with the colours and the spectrum of that crop",
        "as synth",
        _synth_large,
        model="texture",
        embedding="embedding",
        seam_correction=True,
    )
)
register(
    TextureMethod(
        "exemplar",
        "quilted from its crops; as synth where they are too poor",
        "the house's nearest exemplar; as synth where none is near",
        _exemplar,
        seam_correction=True,
        fallback="synth",
    )
)
register(
    TextureMethod(
        "medoid_colour",
        "the median colour of its reference crop (IM2CAD)",
        "the median colour of a crop of another surface",
        _medoid_colour,
        library=True,
        crop_pool=True,
    )
)
register(
    TextureMethod(
        "projection",
        "its largest crop, stretched over it (Rent3D)",
        "a crop of another surface, stretched over it",
        _projection,
        library=True,
        crop_pool=True,
    )
)
