"""Texture tiles of surfaces, with their metric size, as a stage left them in a folder."""

from __future__ import annotations

import hashlib
import logging
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plan2scene.errors import InputError
from plan2scene.house import House, SurfaceKey
from plan2scene.images import png_bytes, read_image
from plan2scene.io import read_json

#: Colours of surfaces that have no texture, sRGB 0..255.
UNTEXTURED = {"floor": (178, 164, 148), "wall": (232, 228, 220), "ceiling": (244, 243, 240)}


@dataclass(frozen=True)
class TileTexture:
    """A repeating texture.

    Attributes
    ----------
    png : bytes
        PNG, sRGB.
    size_m : float
        Metres that the tile's side covers.
    observed : bool or None
        Whether photos showed the surface; None when unknown.
    substance : str or None
        One of ``house.SUBSTANCES``.
    source : str
        Where it comes from, in words.
    origin_m : (2,) tuple of float
        Where a tile begins in a part's texture coordinates, metres.
    """

    png: bytes
    size_m: float
    observed: bool | None = None
    substance: str | None = None
    source: str = ""
    origin_m: tuple[float, float] = (0.0, 0.0)

    @property
    def digest(self) -> str:
        """Hash of the pixels' file: equal textures are embedded once."""
        return hashlib.sha256(self.png).hexdigest()

    def turns(self, uv: np.ndarray) -> np.ndarray:
        """Return texture coordinates (..., 2) in tiles, from metres."""
        return np.asarray((uv - np.array(self.origin_m)) / self.size_m)


def load_textures(folder: str | Path, house: House) -> dict[SurfaceKey, TileTexture]:
    """Return the textures that a method left for a house (``textures.json`` and PNG tiles).

    Surfaces that the folder does not list are left out, with a warning in the log.

    Raises
    ------
    InputError
        When textures.json is not of the form in docs/conventions.md or a tile is no image.
    """
    root = Path(folder)
    index = read_json(root / "textures.json")
    entries = index.get("surfaces") if isinstance(index, dict) else None
    if not isinstance(entries, dict):
        raise InputError(
            "an object 'surfaces'", "none", file=root / "textures.json", house=house.id
        )
    textures: dict[SurfaceKey, TileTexture] = {}
    for key in house.surface_keys():
        entry = entries.get(f"{key.room_id}/{key.surface}")
        if entry is None:
            logging.getLogger("plan2scene").warning(
                "house %s: no texture for %s/%s", house.id, key.room_id, key.surface
            )
            continue
        textures[key] = _tile(root, key, entry, house.id)
    return textures


def _tile(root: Path, key: SurfaceKey, entry: dict[str, object], house_id: str) -> TileTexture:
    """Return one tile of a textures folder."""

    def fault(expected: str, found: object) -> InputError:
        index = root / "textures.json"
        return InputError(expected, str(found), file=index, house=house_id, room=key.room_id)

    size = entry.get("size_m")
    if not isinstance(size, int | float) or not 0 < size < 1000:
        raise fault("a size_m in metres over 0", size)
    origin = entry.get("origin_m", [0.0, 0.0])
    if not (
        isinstance(origin, list)
        and len(origin) == 2
        and all(isinstance(v, int | float) and abs(v) < 1e6 for v in origin)
    ):
        raise fault("an origin_m of two numbers of metres", origin)
    file = root / f"{key.filename}.png"
    try:
        data = file.read_bytes()
    except OSError:
        raise InputError("a texture", "no such file", file=file, house=house_id) from None
    if not data.startswith(b"\x89PNG"):
        data = png_bytes(read_image(file, house_id=house_id))
    observed, substance = entry.get("observed"), entry.get("substance")
    return TileTexture(
        png=data,
        size_m=float(size),
        observed=observed if isinstance(observed, bool) else None,
        substance=str(substance) if substance else None,
        source=str(entry.get("source", "")),
        origin_m=(float(origin[0]), float(origin[1])),
    )
