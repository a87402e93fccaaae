"""Texture tiles of surfaces, with their metric size, read from the folder of a stage."""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from plan2scene.colour import as_uint8, linear_to_srgb, srgb_to_linear
from plan2scene.errors import InputError
from plan2scene.house import House, SurfaceKey
from plan2scene.images import image_from_bytes, png_bytes, read_image
from plan2scene.stage_json import read_stage_json

#: Colours of surfaces that have no texture, sRGB 0..255.
UNTEXTURED = {"floor": (178, 164, 148), "wall": (232, 228, 220), "ceiling": (244, 243, 240)}


@dataclass(frozen=True)
class TileTexture:
    """A repeating texture, or with a `jpeg` a surface map: one image for the whole surface."""

    png: bytes  #: the tile, sRGB
    size_m: float  #: metres that the tile's side covers
    observed: bool | None = None  #: whether photos showed the surface; None when unknown
    substance: str | None = None  #: one of ``house.SUBSTANCES``
    source: str = ""  #: where it comes from, in words
    #: where tile or map begins in a part's texture coordinates, metres
    origin_m: tuple[float, float] = (0.0, 0.0)
    material: str = ""  #: name of the material that it shares with other rooms, or empty
    crops: tuple[str, ...] = ()  #: ids of the crops that it was quilted from
    #: how its look is known (:mod:`plan2scene.textures.painted`); empty when unknown
    evidence: Mapping[str, object] = field(default_factory=dict)
    jpeg: bytes = b""  #: the map, sRGB; empty for none
    extent_m: tuple[float, float] | None = None  #: metres that the map's width and height cover
    pattern: str = ""  #: kind and size of the units that the map is laid of, in words

    @property
    def image(self) -> bytes:
        """The file that a mesh shows."""
        return self.jpeg or self.png

    @property
    def suffix(self) -> str:
        """``.png`` or ``.jpg``: what kind of file `image` is."""
        return ".jpg" if self.jpeg else ".png"

    @property
    def sides_m(self) -> tuple[float, float]:
        """Metres that the image's width and height cover."""
        return self.extent_m or (self.size_m, self.size_m)

    @property
    def digest(self) -> str:
        """Hash of the pixels' file: equal textures are embedded once."""
        return hashlib.sha256(self.image).hexdigest()

    def turns(self, uv: np.ndarray) -> np.ndarray:
        """Convert texture coordinates (..., 2) from metres to multiples of the image's sides."""
        return np.asarray((uv - np.array(self.origin_m)) / np.array(self.sides_m))


def load_textures(folder: str | Path, house: House) -> dict[SurfaceKey, TileTexture]:
    """Return the textures that a method made for a house (``textures.json``, tiles, maps).

    A surface that ``maps.json`` lists gets its map. Those that ``textures.json`` does
    not list are left out, with a warning in the log. Raises InputError when ``textures.json`` is
    not of the form in docs/conventions.md or a tile is no image.
    """
    root = Path(folder)
    entries = texture_index(root, house)
    maps = {}
    if (root / "maps.json").is_file():
        maps = read_stage_json(root / "maps.json", "maps", house=house)["surfaces"]
    textures: dict[SurfaceKey, TileTexture] = {}
    for key in house.surface_keys():
        entry = entries.get(f"{key.room_id}/{key.surface}")
        if entry is None:
            logging.getLogger("plan2scene").warning(
                "house %s: no texture for %s/%s", house.id, key.room_id, key.surface
            )
            continue
        textures[key] = _tile(root, key, entry, house.id)
        if "/".join(key) in maps:
            surface_map = maps["/".join(key)]
            (x, y), (width, height) = surface_map["origin_m"], surface_map["extent_m"]
            textures[key] = replace(
                textures[key],
                origin_m=(float(x), float(y)),
                jpeg=_bytes(root / f"{key.filename}.jpg", house.id),
                extent_m=(float(width), float(height)),
                pattern=surface_map.get("pattern", ""),
            )
    return textures


def textured(folder: str | Path, house: House) -> tuple[House, dict[SurfaceKey, TileTexture]]:
    """Return a house completed from a folder of textures, and all its textures.

    The house gets its accent walls (those with a texture), the colours of door leaves and trim
    (``doors.json``, ``trim.json``) and of stairs. Raises as :func:`load_textures`.
    """
    entries = texture_index(folder, house)
    sides = (
        SurfaceKey(room_id, f"wall.{wall.id}") for wall in house.walls for room_id in wall.room_ids
    )
    accents = tuple(key for key in sides if "/".join(key) in entries)
    doors, trim = (_colours(Path(folder), kind, house) for kind in ("doors", "trim"))
    house = replace(house, accents=accents, door_colours=doors, trim_colours=trim)
    textures = load_textures(folder, house)
    return replace(house, stair_colours=tuple(_stair_colours(house, textures))), textures


def _stair_colours(
    house: House, textures: Mapping[SurfaceKey, TileTexture]
) -> Iterator[tuple[str, tuple[int, int, int]]]:
    """Yield the sRGB colours of stairs by id: the mean of the floor that they lead to.

    If photos show only the floor that they start from, it is that floor's.
    """
    for flight in house.stairs:
        ends = (SurfaceKey(room, "floor") for room in reversed(flight.room_ids) if room)
        floors = [textures[key] for key in ends if key in textures]
        observed = [tile for tile in floors if tile.observed]
        for tile in (observed or floors)[:1]:
            mean = srgb_to_linear(image_from_bytes(tile.png)).mean(axis=(0, 1))
            r, g, b = as_uint8(linear_to_srgb(mean)).tolist()
            yield flight.id, (r, g, b)


def _colours(folder: Path, kind: str, house: House) -> tuple[tuple[str, tuple[int, int, int]], ...]:
    """Return the sRGB colours of doors or trim by id; none where there is no such file."""
    file = folder / f"{kind}.json"
    if not file.is_file():
        return ()
    entries = read_stage_json(file, kind, house=house)
    return tuple((name, (int(r), int(g), int(b))) for name, (r, g, b) in entries.items())


def texture_index(folder: str | Path, house: House | None = None) -> dict[str, dict[str, Any]]:
    """Return the entries of a folder's ``textures.json`` by ``room/surface``."""
    index = read_stage_json(Path(folder) / "textures.json", "textures", house=house)
    return dict(index["surfaces"])


def _tile(root: Path, key: SurfaceKey, entry: dict[str, Any], house_id: str) -> TileTexture:
    """Return one texture of a folder."""
    file = root / f"{key.filename}.png"
    data = _bytes(file, house_id)
    if not data.startswith(b"\x89PNG"):
        data = png_bytes(read_image(file, house_id=house_id))
    x, y = entry.get("origin_m", (0.0, 0.0))
    return TileTexture(
        png=data,
        size_m=float(entry["size_m"]),
        observed=entry.get("observed"),
        substance=entry.get("substance") or None,
        source=entry.get("source", ""),
        origin_m=(float(x), float(y)),
        material=entry.get("material", ""),
        crops=tuple(entry.get("crops", ())),
        evidence=entry.get("evidence", {}),
    )


def _bytes(file: Path, house_id: str) -> bytes:
    """Return a texture's file."""
    try:
        return file.read_bytes()
    except OSError:
        raise InputError("a texture", "no such file", file=file, house=house_id) from None
