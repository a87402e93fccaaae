"""Replace textures of a house by finishes that its owner chose (:mod:`plan2scene_app.finishes`)."""

from __future__ import annotations

import logging
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from plan2scene.colour import as_uint8, linear_to_srgb, median_colour, srgb_to_linear
from plan2scene.house import SurfaceKey
from plan2scene.images import read_image, write_png
from plan2scene.io import read_parquet, write_json
from plan2scene.materials import random_material
from plan2scene.paint.estimate import PaintPrior
from plan2scene.paint.light import repainted
from plan2scene.paint.surfaces import read_paint
from plan2scene.stage_json import read_stage_json
from plan2scene.textures.crops import Crop
from plan2scene_app.finishes import BY_HAND, LIBRARY, SEEDS
from plan2scene_app.single_tile import tile_from_crops

_LOG = logging.getLogger("plan2scene")
#: Side of a tile of one colour in pixels, and the metres that it covers.
_FLAT_PX, _FLAT_M = 16, 1.0


def set_by_hand(
    folder: str | Path,
    finishes: Mapping[SurfaceKey, str],
    crops: str | Path,
    paint: str | Path,
    *,
    openings: Collection[str],
) -> None:
    """Change a textures folder in place: its surfaces get the finishes that the owner chose.

    Tiles of all other surfaces keep their bytes. A finish that names a room, wall, door or
    photo that the house does not have is left out, with a warning.

    Parameters
    ----------
    folder : path
        Textures in paint: tiles, ``textures.json``, ``maps.json``, ``doors.json``.
    crops : path
        ``crops.parquet``: finishes ``photo:{name}`` take their crops from it.
    paint : path
        ``paint.parquet``: the paint of the surfaces that those crops show.
    openings : collection of str
        Ids of the house's openings.
    """
    root = Path(folder)
    index = read_stage_json(root / "textures.json", "textures")
    entries = {SurfaceKey(*name.rsplit("/", 1)): e for name, e in index["surfaces"].items()}
    _warn_of_unknown(finishes, entries, openings)
    chosen = _spread(finishes, list(entries))
    house = _House(root, entries, chosen, Path(crops), Path(paint))
    tile_by_key = {key: tile for key in chosen if (tile := house.tile(key)) is not None}
    for key, tile in tile_by_key.items():
        write_png(root / f"{key.filename}.png", tile.image)
        size = {"size_m": tile.size_m, "observed": None, "substance": tile.substance}
        source = BY_HAND + chosen[key]
        words = source.replace("same:", "as in ").replace("photo:", "as in photo ")
        evidence: dict[str, Any] = {"photos": [], "like": None, "words": words}
        index["surfaces"]["/".join(key)] = size | {"source": source, "evidence": evidence}
        (root / f"{key.filename}.jpg").unlink(missing_ok=True)
    write_json(root / "textures.json", index)
    if (root / "maps.json").is_file():
        maps = read_stage_json(root / "maps.json", "maps")
        names = {"/".join(key) for key in tile_by_key}
        other_entries = {
            name: entry for name, entry in maps["surfaces"].items() if name not in names
        }
        write_json(root / "maps.json", maps | {"surfaces": other_entries})
    doors = read_stage_json(root / "doors.json", "doors")
    if SurfaceKey("*", "door") in finishes:
        doors = {}
    write_json(root / "doors.json", doors | _colours("door", finishes))
    if trim := _colours("trim", finishes):
        trim_file = root / "trim.json"
        trim_colours = read_stage_json(trim_file, "trim") if trim_file.is_file() else {}
        write_json(trim_file, trim_colours | trim)


@dataclass(frozen=True)
class _Tile:
    """A tile (n, n, 3) uint8 sRGB, the metres that its side covers, and its substance."""

    image: np.ndarray
    size_m: float
    substance: str | None


@dataclass
class _House:
    """The existing tiles of a house (`entries`) and the finishes `chosen` for its surfaces."""

    root: Path
    entries: Mapping[SurfaceKey, Mapping[str, Any]]
    chosen: Mapping[SurfaceKey, str]
    crops: Path
    paint: Path
    _pending: set[SurfaceKey] = field(default_factory=set)

    def tile(self, key: SurfaceKey) -> _Tile | None:
        """Return the tile of a surface's chosen finish; None, with a warning, if there is none."""
        what = self.chosen[key]
        form, _, name = what.partition(":")
        if form == "same":
            return self._same(key, SurfaceKey(name, key.surface.partition(".")[0]))
        if form == "photo":
            return self._of_photo(key, name)
        if what in LIBRARY:
            substance, kind, colour = LIBRARY[what]
            levels = tuple(int(level) for level in _levels(colour))
            material = random_material(
                *(substance, SEEDS.get(what, 1)),
                kind=kind,
                colour_rgb=(levels[0], levels[1], levels[2]),
            )
            return _Tile(material.albedo, material.size_m, substance)
        flat = np.broadcast_to(_levels(what), (_FLAT_PX, _FLAT_PX, 3))
        return _Tile(np.ascontiguousarray(flat), _FLAT_M, "plaster")

    def _same(self, key: SurfaceKey, other: SurfaceKey) -> _Tile | None:
        if other not in self.entries or other == key or other in self._pending:
            why = "no such surface, or a circle of them"
            _LOG.warning("finish same:%s of %s/%s is left out: %s", other.room_id, *key, why)
            return None
        if other in self.chosen:
            self._pending.add(key)
            try:
                return self.tile(other)
            finally:
                self._pending.discard(key)
        entry = self.entries[other]
        image = read_image(self.root / f"{other.filename}.png")
        return _Tile(image, float(entry["size_m"]), entry.get("substance"))

    def _of_photo(self, key: SurfaceKey, photo: str) -> _Tile | None:
        """Return a tile made from a photo's crops of this kind of surface, in their paint colour.

        If the crops are of several surfaces, those of the surface with most crops are used.
        """
        table, _ = read_parquet(self.crops)
        kind = key.surface.partition(".")[0]
        rows = table[(table["photo"] == photo) & (table["surface"] == kind)]
        if rows.empty:
            why = f"the photo has no crop of a {kind}"
            _LOG.warning("finish photo:%s of %s/%s is left out: %s", photo, *key, why)
            return None
        crops = [Crop.of(row) for row in rows.itertuples()]
        source = max(
            {c.key for c in crops}, key=lambda one: (sum(c.key == one for c in crops), one)
        )
        crops = [crop for crop in crops if crop.key == source]
        source_entry = self.entries.get(source, {})
        image = tile_from_crops([crop.image() for crop in crops], "exemplar", size_px=256, seed=0)
        paints, _ = read_paint(self.paint)
        if source in paints:
            photo_colour = np.maximum(srgb_to_linear(median_colour(image)), 1e-3)
            image = repainted(image, paints[source] / photo_colour, knee=0.88)
        sizes = [crop.size_m for crop in crops if np.isfinite(crop.size_m)]
        size_m = float(np.median(sizes)) if sizes else float(source_entry.get("size_m", 1.0))
        return _Tile(image, size_m, source_entry.get("substance"))


def _levels(what: str) -> np.ndarray:
    """Return a colour as (3,) uint8 sRGB; ``white`` is usual white paint, not (255, 255, 255)."""
    if what == "white":
        return as_uint8(linear_to_srgb(np.exp(PaintPrior().white[0]) * np.ones(3)))
    return np.array([int(what[k : k + 2], 16) for k in (1, 3, 5)], np.uint8)


def _warn_of_unknown(
    finishes: Mapping[SurfaceKey, str], keys: Iterable[SurfaceKey], openings: Collection[str]
) -> None:
    """Warn of each finish that is of no surface, door or room of the house."""
    known = {(key.room_id, key.surface.partition(".")[0]) for key in keys} | set(keys)
    known |= {(key.room_id, "trim") for key in keys} | {(opening, "door") for opening in openings}
    for room, surface in sorted(key for key in finishes if key.room_id != "*"):
        if (room, surface) not in known:
            _LOG.warning(
                "finish of %s/%s is left out: the house has no such surface", room, surface
            )


def _spread(finishes: Mapping[SurfaceKey, str], keys: list[SurfaceKey]) -> dict[SurfaceKey, str]:
    """Return the finish chosen for each surface of a house: the most specific row decides.

    A row for one wall overrides a row for all walls of its room; that one overrides ``*``.
    """
    chosen = {}
    for key in keys:
        kind = key.surface.partition(".")[0]
        rows = [key, SurfaceKey(key.room_id, kind), SurfaceKey("*", kind)]
        finish = next((finishes[row] for row in rows if row in finishes), None)
        if finish is not None:
            chosen[key] = finish
    return chosen


def _colours(kind: str, finishes: Mapping[SurfaceKey, str]) -> dict[str, list[int]]:
    """Return the chosen colours of doors (by opening id) or trim (by room id); ``""`` is all."""
    return {
        "" if key.room_id == "*" else key.room_id: [int(level) for level in _levels(what)]
        for key, what in finishes.items()
        if key.surface == kind
    }
