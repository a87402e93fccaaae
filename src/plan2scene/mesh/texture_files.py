"""Texture tiles of surfaces, with their metric size, as a stage left them in a folder."""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
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
    material : str
        Name of what it shares with other rooms, or empty.
    crops : tuple of str
        Ids of the crops that it was quilted from.
    evidence : mapping
        How its look is known (:mod:`plan2scene.textures.evidence`); empty when unknown.
    """

    png: bytes
    size_m: float
    observed: bool | None = None
    substance: str | None = None
    source: str = ""
    origin_m: tuple[float, float] = (0.0, 0.0)
    material: str = ""
    crops: tuple[str, ...] = ()
    evidence: Mapping[str, object] = field(default_factory=dict)

    @property
    def image(self) -> bytes:
        """The file that a mesh shows."""
        return self.png

    @property
    def suffix(self) -> str:
        """``.png`` or ``.jpg``: what kind of file `image` is."""
        return ".png"

    @property
    def sides_m(self) -> tuple[float, float]:
        """Metres that the image's width and height cover."""
        return self.size_m, self.size_m

    @property
    def digest(self) -> str:
        """Hash of the pixels' file: equal textures are embedded once."""
        return hashlib.sha256(self.image).hexdigest()

    def turns(self, uv: np.ndarray) -> np.ndarray:
        """Return texture coordinates (..., 2) in images, from metres."""
        return np.asarray((uv - np.array(self.origin_m)) / np.array(self.sides_m))


@dataclass(frozen=True)
class MapTexture(TileTexture):
    """A surface map in the place of its tile: one image for the whole surface.

    `origin_m` is where the map begins.

    Attributes
    ----------
    jpeg : bytes
        JPEG, sRGB.
    extent_m : (2,) tuple of float
        Metres that its width and height cover.
    pattern : str
        Kind and size of the units that it is laid of, in words; empty for none.
    """

    jpeg: bytes = b""
    extent_m: tuple[float, float] = (1.0, 1.0)
    pattern: str = ""

    @property
    def image(self) -> bytes:
        """The file that a mesh shows."""
        return self.jpeg

    @property
    def suffix(self) -> str:
        """``.jpg``."""
        return ".jpg"

    @property
    def sides_m(self) -> tuple[float, float]:
        """Metres that the image's width and height cover."""
        return self.extent_m


def load_textures(folder: str | Path, house: House) -> dict[SurfaceKey, TileTexture]:
    """Return the textures that a method left for a house (``textures.json``, tiles, maps).

    A surface that ``maps.json`` lists gets a :class:`MapTexture`. Those that ``textures.json`` does
    not list are left out, with a warning in the log.

    Raises
    ------
    InputError
        When textures.json is not of the form in docs/conventions.md or a tile is no image.
    """
    root = Path(folder)
    entries = texture_index(root / "textures.json", house.id)
    maps = {}
    if (root / "maps.json").is_file():
        maps = texture_index(root / "maps.json", house.id)
    textures: dict[SurfaceKey, TileTexture] = {}
    for key in house.surface_keys():
        entry = entries.get(f"{key.room_id}/{key.surface}")
        if entry is None:
            logging.getLogger("plan2scene").warning(
                "house %s: no texture for %s/%s", house.id, key.room_id, key.surface
            )
            continue
        tile = _tile(root, key, entry, house.id)
        whole = maps.get("/".join(key))
        textures[key] = tile if whole is None else _map(root, key, tile, whole, house.id)
    return textures


def textured(folder: str | Path, house: House) -> tuple[House, dict[SurfaceKey, TileTexture]]:
    """Return a house with what a folder knows of it, and all its textures.

    That is the accent walls that it has textures of, and the colours of door leaves
    (``doors.json``). As :func:`load_textures`.
    """
    entries = texture_index(Path(folder) / "textures.json", house.id)
    sides = (
        SurfaceKey(room_id, f"wall.{wall.id}") for wall in house.walls for room_id in wall.room_ids
    )
    accents = tuple(key for key in sides if "/".join(key) in entries)
    doors = _door_colours(Path(folder) / "doors.json", house.id)
    house = replace(house, accents=accents, door_colours=doors)
    return house, load_textures(folder, house)


def _door_colours(file: Path, house_id: str) -> tuple[tuple[str, tuple[int, int, int]], ...]:
    """Return the sRGB colours of door leaves by opening id; none where there is no such file."""
    if not file.is_file():
        return ()
    entries = read_json(file)
    colours = []
    for name, colour in entries.items() if isinstance(entries, dict) else [("", None)]:
        levels = colour if isinstance(colour, list) else []
        levels = [level for level in levels if isinstance(level, int) and 0 <= level <= 255]
        if len(levels) != 3 or levels != colour:
            expected = "three levels 0 to 255 for each door"
            raise InputError(expected, f"{name!r}: {colour}", file=file, house=house_id)
        red, green, blue = levels
        colours.append((str(name), (red, green, blue)))
    return tuple(colours)


def texture_index(file: Path, house_id: str = "") -> dict[str, dict[str, object]]:
    """Return the entries of ``textures.json`` or ``maps.json`` by ``room/surface``.

    InputError for a file of another form.
    """
    index = read_json(file)
    entries = index.get("surfaces") if isinstance(index, dict) else None
    if not isinstance(entries, dict):
        raise InputError("an object 'surfaces'", "none", file=file, house=house_id)
    for name, entry in entries.items():
        if "/" not in name or not isinstance(entry, dict):
            expected = "'room/surface' and an object for each surface"
            raise InputError(expected, repr(name), file=file, house=house_id)
    return entries


def _tile(root: Path, key: SurfaceKey, entry: dict[str, object], house_id: str) -> TileTexture:
    """Return one texture of a folder."""

    def fault(expected: str, found: object) -> InputError:
        index = root / "textures.json"
        return InputError(expected, str(found), file=index, house=house_id, room=key.room_id)

    size = entry.get("size_m")
    if not isinstance(size, int | float) or not 0 < size < 1000:
        raise fault("a size_m in metres over 0", size)
    origin = _pair(entry.get("origin_m", [0.0, 0.0]))
    if origin is None:
        raise fault("an origin_m of two numbers of metres", entry.get("origin_m"))
    file = root / f"{key.filename}.png"
    data = _bytes(file, house_id)
    if not data.startswith(b"\x89PNG"):
        data = png_bytes(read_image(file, house_id=house_id))
    observed, substance = entry.get("observed"), entry.get("substance")
    evidence = entry.get("evidence")
    crops = entry.get("crops")
    return TileTexture(
        png=data,
        size_m=float(size),
        observed=observed if isinstance(observed, bool) else None,
        substance=str(substance) if substance else None,
        source=str(entry.get("source", "")),
        origin_m=origin,
        material=str(entry.get("material", "")),
        crops=tuple(map(str, crops)) if isinstance(crops, list) else (),
        evidence=evidence if isinstance(evidence, dict) else {},
    )


def _map(
    root: Path, key: SurfaceKey, tile: TileTexture, entry: dict[str, object], house_id: str
) -> MapTexture:
    """Return the map of a surface that has a tile."""
    corner, extent = _pair(entry.get("origin_m")), _pair(entry.get("extent_m"))
    if corner is None or extent is None or min(extent) <= 0:
        expected = "a map with origin_m and extent_m, two numbers of metres each"
        file = root / "maps.json"
        raise InputError(expected, str(entry), file=file, house=house_id, room=key.room_id)
    facts = {item.name: getattr(tile, item.name) for item in fields(tile)}
    jpeg = _bytes(root / f"{key.filename}.jpg", house_id)
    pattern = str(entry.get("pattern", ""))
    return MapTexture(**facts | {"origin_m": corner}, jpeg=jpeg, extent_m=extent, pattern=pattern)


def _bytes(file: Path, house_id: str) -> bytes:
    """Return a texture's file."""
    try:
        return file.read_bytes()
    except OSError:
        raise InputError("a texture", "no such file", file=file, house=house_id) from None


def _pair(value: object) -> tuple[float, float] | None:
    """Return two numbers of metres; None for anything else."""
    if not isinstance(value, list) or len(value) != 2:
        return None
    if not all(isinstance(v, int | float) and abs(v) < 1e6 for v in value):
        return None
    return float(value[0]), float(value[1])
