"""Materials of homes: procedural textures that tile, with a metric size, and folders of scans."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from plan2scene.materials import carpet, palettes, plaster, tile, wood
from plan2scene.materials.folder import load_texture_folder
from plan2scene.materials.material import Look, Material
from plan2scene.seeds import generator

__all__ = ["KINDS", "Material", "load_texture_folder", "random_material"]

_Maker = Callable[[np.random.Generator, str, int, "np.ndarray | None"], Look]

#: Kinds of each substance and how often each is drawn.
KINDS: Mapping[str, Mapping[str, float]] = {
    "wood": {"planks": 0.45, "strip": 0.15, "basket": 0.12, "herringbone": 0.18, "plain": 0.1},
    "plaster": {"paint": 0.35, "plaster": 0.3, "concrete": 0.15, "wallpaper": 0.2},
    "carpet": {"loop": 0.3, "cut": 0.35, "fleck": 0.15, "patterned": 0.2},
    "tile": {
        "grid": 0.28,
        "diagonal": 0.06,
        "checker": 0.06,
        "mosaic": 0.14,
        "brick": 0.16,
        "hexagon": 0.08,
        "marble": 0.12,
        "terrazzo": 0.1,
    },
}
_MAKERS: Mapping[str, _Maker] = {
    "wood": wood.make,
    "plaster": plaster.make,
    "carpet": carpet.make,
    "tile": tile.make,
}


def random_material(
    substance: str,
    seed: int,
    *,
    kind: str | None = None,
    size_px: int = 256,
    colour_rgb: tuple[int, int, int] | None = None,
) -> Material:
    """Return a random material of a substance (``house.SUBSTANCES``); same seed, same bytes.

    The seed decides colour, scale, wear and contrast. If they are not given, it also decides `kind`
    (of ``KINDS[substance]``) and the main colour `colour_rgb` (sRGB, 0 to 255). `size_px` is the
    side of the albedo tile in pixels. ValueError for an unknown substance or kind, or a size below
    32.
    """
    if substance not in KINDS:
        raise ValueError(f"expected a substance of {tuple(KINDS)}, found {substance!r}")
    kinds = KINDS[substance]
    if kind is not None and kind not in kinds:
        raise ValueError(f"expected a kind of {tuple(kinds)}, found {kind!r}")
    if size_px < 32:
        raise ValueError(f"expected size_px >= 32, found {size_px}")
    rng = generator(seed, "material", substance)
    drawn = str(rng.choice(list(kinds), p=list(kinds.values())))
    kind = kind or drawn
    base = None if colour_rgb is None else np.array(colour_rgb, np.float32) / 255
    image, size_m, roughness = _MAKERS[substance](rng, kind, size_px, base)
    return Material(
        name=f"{substance}-{kind}-{int(rng.integers(2**32)):08x}",
        substance=substance,
        kind=kind,
        albedo=palettes.to_uint8(image),
        size_m=size_m,
        roughness=roughness,
    )
