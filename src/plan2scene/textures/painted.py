"""Textures of a house in the colours of its paint: what the 3D house shows.

Tiles and maps are made in the colours of the photos, which hold their light. A viewer lights the
house again, so its textures are to hold paint alone.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from plan2scene.colour import (
    LUMINANCE,
    RENDER,
    as_uint8,
    from_log_axes,
    linear_to_srgb,
    log_axes,
    median_colour,
    srgb_to_linear,
)
from plan2scene.house import SURFACES, SurfaceKey
from plan2scene.images import jpeg_bytes, read_image, write_png
from plan2scene.io import atomic_directory, write_json
from plan2scene.mesh.texture_files import texture_index
from plan2scene.paint.estimate import PaintPrior
from plan2scene.paint.light import relight
from plan2scene.paint.surfaces import (
    TRIM,
    door_paints,
    grey_floor,
    paint_gains,
    panelling,
    plain_whites,
    read_paint,
    read_seen_photos,
)
from plan2scene.plans.parse import ID_PATTERN
from plan2scene.stage_json import read_stage_json

_QUALITY = 85  #: JPEG quality of maps, as of those that are painted
#: Linear value on from which brightened values bend, so that none burns out: above white paint.
_KNEE = 0.88
#: Patterns of white surfaces that are fainter (standard deviation of log brightness) are grain or
#: relief: .006 to .027 on plain walls of real and synthetic homes (development), .03 to .06 on
#: tiles, wallpaper and rough ceilings.
FAINT = 0.028
#: Patterns of white walls that are stronger are blinds, pictures, a splashback: .18 and .20 in a
#: real listing (development); tiles and curtains have .06 at most.
LOUD = 0.12
#: Patterns of white walls of which more than the first share of the variance is the same from top
#: to bottom, and less than the second from side to side, are folds of curtains, corners and edges
#: of light: .38 to .8 and 0 to .12 in three real homes (development); of tiles both are above .26.
UPRIGHT = (0.3, 0.15)
PATTERNED = ("tile", "wood")  #: Substances whose patterns are no stains
_BLACK = 1e-3  #: Least linear value of a texture's median
#: Factors of the channels that differ by more make another colour (light does 2.5 at most): noise
#: of a channel that was nearly black would become blotches of its colour.
_TURNED = 3.0
#: Carpets with fainter :func:`stains` have no pattern, but wear and light: .005 to .05 in three
#: real homes (development); .10 for the faint dots of a carpet of the demo.
PLAIN_CARPET = 0.07
#: What balconies, terraces and yards have where no photo shows them, since carpets and wallpapers
#: stay indoors: linear RGB and substances of grey stone (a garage's floor, too) and of render.
OUTDOORS = {
    "floor": (np.full(3, 0.30), "tile"),
    "wall": (srgb_to_linear(np.array(RENDER, np.uint8)), "plaster"),
}
#: Mean CIEDE2000 to the true material by kind of surface, seen and not, and of a seen wall or
#: ceiling of a colour: 43 synthetic homes with 60 % of their photos hidden (development).
SEEN, UNSEEN, COLOURED = (8.3, 6.2, 2.6), (16.1, 11.9, 2.6), 12.9
DOUBTFUL = 10.0  #: Expected error from which on people are told of it


@dataclass(frozen=True)
class PlainSettings:
    """What is light and noise on plain paint. Chosen by looking at a real flat (development).

    White paint has one colour. What varies slowly over a white wall is its light, and faint colours
    of its grain are the noise of a dim photo; relief and coloured patterns stay.
    """

    slow_m: float = 0.1  #: standard deviation, metres, of the filter before a pattern is measured
    smear_m: float = 0.03  #: of the filter that takes light, smears and lens dirt of plain paint
    #: What stands out more from paint, in median deviations of its grain and relief, is a nail, a
    #: hook, a crack: nothing that a tile may repeat.
    relief: float = 4.5
    noise: float = 0.06  #: fainter colours (log red or blue against green) are noise
    brightest: float = 0.95  #: linear


_PLAIN = PlainSettings()


def paint_textures(
    textures: str | Path,
    paint: str | Path,
    out_dir: str | Path,
    *,
    open_air: Collection[str] = (),
    garages: Collection[str] = (),
    bathrooms: Collection[str] = (),
    uncarpeted: Collection[str] = (),
    last_word: Callable[[Path], None] | None = None,
) -> None:
    """Write a textures folder whose tiles and maps have the colours of ``paint.parquet``.

    The folder has the files of the first one, without maps of plain white surfaces and plain
    carpets, whose tile has all that there is, and ``doors.json``: sRGB levels of door leaves by the
    id of their opening; ``trim.json`` of frames and skirting where these are of wood. An accent
    wall has its room's pattern in its own paint, walls of one panelling have one pattern. An unseen
    white wall has no pattern of another room, unseen floors and walls of `bathrooms` (their ids)
    are as in another one, unseen floors of those `uncarpeted` are no carpet, unseen surfaces
    of rooms in the `open_air` are of stone and render, unseen floors of `garages` of stone.
    `last_word` may change the folder before it takes its place.
    """
    root = Path(textures)
    listed = texture_index(root)
    entries = {SurfaceKey(*name.rsplit("/", 1)): entry for name, entry in listed.items()}
    tiles = {key: read_image(root / f"{key.filename}.png") for key in entries}
    paints, white_surfaces = read_paint(paint)
    for key in paints:
        usual = SurfaceKey(key.room_id, key.kind)
        if key != usual and usual in entries and ID_PATTERN.fullmatch(key.surface):
            tiles[key], entries[key] = tiles[usual], entries[usual] | {"observed": True}
            if usual not in paints:  # its crops show the accent
                entries[usual] = entries[usual] | {"observed": False}
    unseen = {key for key, entry in entries.items() if entry.get("observed") is False}
    alike = _other_bathrooms(bathrooms, entries, paints)
    alike |= _without_carpet(uncarpeted, bathrooms, entries, paints)
    unseen -= alike.keys()
    whites = plain_whites(paints, white_surfaces, unseen, open_air)  # by what photos show
    panels = _one_panelling(entries, paints, white_surfaces, unseen - paints.keys() - whites)
    for key, other in panels.items():
        tiles[key], paints[key] = tiles[other], paints[other]
        entries[key] = entries[other] | {"observed": key not in unseen}
        entries[key]["source"] = f"panelling, like {other.room_id}"
    for key, other in alike.items():
        tiles[key], paints[key] = tiles[other], paints[other]
        source = f"as the use of the room asks, like {other.room_id}"
        entries[key] = entries[other] | {"observed": False, "source": source}
    white_surfaces |= {key for key, other in alike.items() if other in white_surfaces}
    shown = {
        key: np.maximum(srgb_to_linear(median_colour(tile)), _BLACK) for key, tile in tiles.items()
    }
    white = np.exp(PaintPrior().white[0]) * np.ones(3)
    gains = paint_gains(shown, paints, whites, white)
    photos, rooms = read_seen_photos(paint), {key.room_id for key in entries}
    for key in unseen - paints.keys():
        stone = key.kind == "floor" and entries[key].get("substance") != "wood"
        if stone and _room_of_source(entries[key], rooms) is None:
            gains[key] = grey_floor(gains[key] * shown[key]) / shown[key]
    doors = {
        name: as_uint8(linear_to_srgb(colour)).tolist()
        for name, colour in door_paints(paints, white_surfaces).items()
    }
    trim = {"": as_uint8(linear_to_srgb(paints[TRIM])).tolist()} if TRIM in paints else {}
    if trim and not doors:  # what no photo shows is as the rest of the joinery
        doors = dict(trim)
    has_maps = (root / "maps.json").is_file()
    maps = read_stage_json(root / "maps.json", "maps") if has_maps else {"surfaces": {}}
    banded = {key for key in tiles if "split_m" in maps["surfaces"].get("/".join(key), {})}
    plains = _plain_tiles(
        tiles, gains, entries, (white_surfaces | whites) - banded, whites - banded
    )
    laid = {key for key in tiles if "pattern" in maps["surfaces"].get("/".join(key), {})}
    plains |= _plain_carpets({key: tiles[key] for key in tiles.keys() - laid}, gains, entries)
    outside = {
        key
        for key in unseen
        if key not in photos
        and (
            (key.room_id in open_air and key.kind in OUTDOORS)
            or (key.room_id in garages and key.kind == "floor")
        )
    }
    plains |= _open_air_tiles({key: tiles[key] for key in outside}, entries)
    entries |= {key: entries[key] | {"source": "as the use of the room asks"} for key in outside}
    with atomic_directory(out_dir) as folder:
        for key, tile in tiles.items():
            bare = plains[key].image if key in plains else repainted(tile, gains[key])
            write_png(folder / f"{key.filename}.png", bare)
            whole = root / f"{key.filename}.jpg"
            if whole.is_file() and key not in plains.keys() | alike.keys() | panels.keys():
                lit = repainted(read_image(whole), gains[key])
                (folder / whole.name).write_bytes(jpeg_bytes(lit, quality=_QUALITY))
        write_json(folder / "doors.json", doors)
        if trim:
            write_json(folder / "trim.json", trim)
        facts = {
            "/".join(key): {"size_m": made.size_m, "substance": made.substance}
            for key, made in plains.items()
        }
        index = read_stage_json(root / "textures.json", "textures")
        sized = {}
        for key, entry in entries.items():
            evidence = evidence_of(
                key,
                entry,
                photos.get(key, ()),
                rooms,
                white=key in whites - outside,
                coloured=key in paints and key not in white_surfaces,
            )
            name = "/".join(key)
            sized[name] = entry | facts.get(name, {}) | {"evidence": evidence}
        write_json(folder / "textures.json", index | {"surfaces": sized})
        if has_maps:
            gone = facts.keys() | {"/".join(key) for key in alike.keys() | panels.keys()}
            kept = {name: e for name, e in maps["surfaces"].items() if name not in gone}
            write_json(folder / "maps.json", maps | {"surfaces": kept})
        if last_word is not None:
            last_word(folder)


def _other_bathrooms(
    bathrooms: Collection[str],
    entries: Mapping[SurfaceKey, Mapping[str, Any]],
    paints: Mapping[SurfaceKey, np.ndarray],
) -> dict[SurfaceKey, SurfaceKey]:
    """Return the floor or wall that each unseen one of a bathroom is like: one with crops first.

    Those whose texture was taken from a bathroom stay as they are.
    """
    wet = [key for key in sorted(entries) if key.room_id in bathrooms and key.kind != "ceiling"]
    seen = [key for key in wet if key in paints]
    seen.sort(key=lambda key: entries[key].get("observed") is False)
    first = {key.surface: key for key in reversed(seen)}
    return {
        key: first[key.surface]
        for key in wet
        if key not in seen
        and key.surface in first
        and _room_of_source(entries[key], bathrooms) is None
    }


def _without_carpet(
    uncarpeted: Collection[str],
    bathrooms: Collection[str],
    entries: Mapping[SurfaceKey, Mapping[str, Any]],
    paints: Mapping[SurfaceKey, np.ndarray],
) -> dict[SurfaceKey, SurfaceKey]:
    """Return the floor that each unseen carpet of rooms `uncarpeted` is like: one with crops.

    That of another such room first, of a bathroom last; none where photos show no bare floor.
    """
    floors = [key for key in sorted(entries) if key.kind == "floor"]
    bare = [
        key
        for key in floors
        if key in paints
        and entries[key].get("observed") is not False
        and entries[key].get("substance") != "carpet"
    ]
    bare.sort(key=lambda key: (key.room_id in bathrooms) - (key.room_id in uncarpeted))
    return {
        key: bare[0]
        for key in floors
        if bare
        and key.room_id in uncarpeted
        and key not in paints
        and entries[key].get("observed") is False
        and entries[key].get("substance") == "carpet"
    }


def _one_panelling(
    entries: Mapping[SurfaceKey, Mapping[str, Any]],
    paints: Mapping[SurfaceKey, np.ndarray],
    white: Collection[SurfaceKey],
    unseen: Collection[SurfaceKey],
) -> dict[SurfaceKey, SurfaceKey]:
    """Return the wall that each other one of a :func:`panelling` is like: its crops show most.

    `unseen` walls that are not white are of it, too.
    """
    panels = [key for key in panelling(paints, white) if key in entries]
    seen = [key for key in panels if entries[key].get("observed") is not False]
    if not seen:
        return {}
    widest = max(seen, key=lambda key: float(entries[key]["size_m"]))
    panels += [key for key in sorted(unseen) if key.surface == "wall"]
    return {key: widest for key in panels if key != widest}


@dataclass(frozen=True)
class _Tile:
    """A tile (n, n, 3) uint8 sRGB, the metres that it covers, how strong its pattern is."""

    image: np.ndarray
    size_m: float
    substance: str | None
    pattern: float


def _plain_tiles(
    tiles: Mapping[SurfaceKey, np.ndarray],
    gains: Mapping[SurfaceKey, np.ndarray],
    entries: Mapping[SurfaceKey, Mapping[str, Any]],
    white: Collection[SurfaceKey],
    unseen: Collection[SurfaceKey],
) -> dict[SurfaceKey, _Tile]:
    """Return the tiles of plain white walls and ceilings.

    An `unseen` one is always plain, and one whose crops show things: as the plainest other one, or
    without any pattern where there is none.
    """
    made, bare = {}, {}
    handed_on = set(unseen)
    for key in sorted(tiles.keys() & set(white)):
        if key.kind in ("wall", "ceiling"):
            image, size_m = tiles[key], float(entries[key]["size_m"])
            colour = gains[key] * srgb_to_linear(median_colour(image))
            image, pattern = plain(image, colour, len(image) / size_m)
            made[key] = _Tile(image, size_m, entries[key].get("substance"), pattern)
            plainer = key.kind == "wall" and made[key].substance not in PATTERNED
            if pattern > LOUD or (plainer and pattern >= FAINT and is_upright(tiles[key], size_m)):
                handed_on.add(key)
            bare[key] = np.full_like(image, as_uint8(linear_to_srgb(np.minimum(colour, 1.0))))
    plainest: dict[str, _Tile] = {}
    for key, tile in sorted(made.items(), key=lambda item: item[1].pattern):
        if key not in handed_on and tile.substance not in PATTERNED:
            plainest.setdefault(key.surface, tile)
    return {
        key: tile
        if tile.pattern < FAINT
        else plainest.get(key.surface, replace(tile, image=bare[key], pattern=0.0))
        for key, tile in made.items()
        if key in handed_on or (tile.pattern < FAINT and tile.substance not in PATTERNED)
    }


def _plain_carpets(
    tiles: Mapping[SurfaceKey, np.ndarray],
    gains: Mapping[SurfaceKey, np.ndarray],
    entries: Mapping[SurfaceKey, Mapping[str, Any]],
) -> dict[SurfaceKey, _Tile]:
    """Return the tiles of carpets without a pattern, which have one colour and their pile."""
    made = {}
    for key in sorted(tiles):
        if key.kind == "floor" and entries[key].get("substance") == "carpet":
            size_m = float(entries[key]["size_m"])
            image, px_per_m = repainted(tiles[key], gains[key]), len(tiles[key]) / size_m
            if stains(image, px_per_m) < PLAIN_CARPET:
                image, pattern = plain(image, srgb_to_linear(median_colour(image)), px_per_m)
                made[key] = _Tile(image, size_m, "carpet", pattern)
    return made


def _open_air_tiles(
    tiles: Mapping[SurfaceKey, np.ndarray], entries: Mapping[SurfaceKey, Mapping[str, Any]]
) -> dict[SurfaceKey, _Tile]:
    """Return tiles in the colours of `OUTDOORS`, of the grain of others where it is faint."""
    made = {}
    for key, tile in tiles.items():
        colour, substance = OUTDOORS[key.kind]
        size_m = float(entries[key]["size_m"])
        image, pattern = plain(tile, colour, len(tile) / size_m)
        if pattern > FAINT:  # joints, folds: not those of stone and render
            image = np.full_like(image, as_uint8(linear_to_srgb(colour)))
        made[key] = _Tile(image, size_m, substance, pattern)
    return made


def repainted(image: np.ndarray, gains: np.ndarray) -> np.ndarray:
    """Return a texture (h, w, 3) uint8 sRGB with its linear RGB times `gains` (3,).

    Where these make it another colour, only the brightness of its pattern is kept.
    """
    if gains.max() > _TURNED * gains.min():
        bright = srgb_to_linear(image) @ LUMINANCE
        paint = gains * np.maximum(srgb_to_linear(median_colour(image)), _BLACK)
        one = paint * (bright / max(float(np.median(bright)), _BLACK))[..., None]
        return as_uint8(linear_to_srgb(np.minimum(one, _PLAIN.brightest)))
    return relight(image, gains, knee=_KNEE)


def plain(image: np.ndarray, colour: np.ndarray, px_per_m: float) -> tuple[np.ndarray, float]:
    """Return a tile in one paint with its relief, and how strong its pattern is.

    `image` and the tile are (h, w, 3) uint8 sRGB, `colour` (3,) is the paint in linear RGB; the
    strength is the standard deviation of log brightness.
    """
    axes = log_axes(srgb_to_linear(image)).astype(np.float32)
    pattern = float((axes - _slow(axes, _PLAIN.slow_m * px_per_m))[..., 0].std())
    detail = axes - _slow(axes, _PLAIN.smear_m * px_per_m)
    faint = np.clip(detail[..., 1:], -_PLAIN.noise, _PLAIN.noise)
    detail[..., 1:] -= faint
    detail[..., 0] -= np.median(detail[..., 0])
    usual = _PLAIN.relief * float(np.median(np.abs(detail[..., 0])))
    detail[..., 0] = np.clip(detail[..., 0], -usual, usual)
    linear = from_log_axes(log_axes(np.asarray(colour)) + detail)
    painted = as_uint8(linear_to_srgb(np.minimum(linear, _PLAIN.brightest)))
    return painted, pattern


def stains(image: np.ndarray, px_per_m: float) -> float:
    """Return how much a texture (h, w, 3) uint8 sRGB varies over centimetres.

    The standard deviation of its log colours between `PlainSettings.smear_m` and `slow_m`.
    """
    axes = log_axes(srgb_to_linear(image)).astype(np.float32)
    smeared, slow = (_slow(axes, m * px_per_m) for m in (_PLAIN.smear_m, _PLAIN.slow_m))
    return float(np.sqrt((smeared - slow).var(axis=(0, 1)).sum()))


def is_upright(image: np.ndarray, size_m: float) -> bool:
    """Return whether the pattern of a tile (h, w, 3) uint8 sRGB runs from top to bottom alone."""
    axes = log_axes(srgb_to_linear(image)).astype(np.float32)[..., :1]
    pattern = (axes - _slow(axes, _PLAIN.slow_m * len(image) / size_m).reshape(axes.shape))[..., 0]
    upright, level = (float(pattern.mean(axis=axis).var()) for axis in (0, 1))
    varies = float(pattern.var())
    return upright > UPRIGHT[0] * varies and level < UPRIGHT[1] * varies


def _slow(axes: np.ndarray, sigma: float) -> np.ndarray:
    """Return the slow part of a tile (h, w, 3) float32, of a filter of so many pixels."""
    pad = int(np.ceil(3 * sigma))
    padded = np.pad(axes, ((pad, pad), (pad, pad), (0, 0)), mode="wrap")
    slow = cv2.GaussianBlur(padded, (0, 0), sigma)
    return np.asarray(slow[pad:-pad, pad:-pad] if pad else slow)


def expected_error(key: SurfaceKey, *, seen: bool, coloured: bool) -> float:
    """Return how far the colour of a surface is expected to be from the truth, CIEDE2000.

    `seen`: photos show its colour; `coloured`: they show that it is not white.
    """
    if coloured and key.kind != "floor":
        return COLOURED
    return (SEEN if seen else UNSEEN)[SURFACES.index(key.kind)]


def evidence_of(
    key: SurfaceKey,
    entry: Mapping[str, Any],
    photos: Sequence[str],
    rooms: Collection[str],
    *,
    white: bool,
    coloured: bool,
) -> dict[str, Any]:
    """Return ``{photos, like, words, expected_error}`` of a surface.

    ``like`` is the room that it is guessed from, the error that of :func:`expected_error`.

    `entry` is what ``textures.json`` says of it, `photos` are those that show its colour, `rooms`
    the ids of the house's rooms. `white`: it is so because most known surfaces of its kind are.
    """
    like = _room_of_source(entry, rooms)
    seen = entry.get("observed") is not False
    room = None if seen or white else like
    count = f"{len(photos)} photo{'s' if len(photos) != 1 else ''}"
    if seen:
        words = f"seen in {count}" if photos else "seen in photos"
    elif photos:
        words = f"colour seen in {count}, the rest guessed"
    elif white:
        words = f"guessed: white, as most {key.kind}s here"
    else:
        words = f"guessed from the {room.replace('_', ' ')}" if room else "guessed"
    off = expected_error(key, seen=bool(photos), coloured=coloured)
    if off >= DOUBTFUL:
        words += "; its colour may be another"
    return {"photos": list(photos), "like": room, "words": words, "expected_error": off}


def _room_of_source(entry: Mapping[str, Any], rooms: Collection[str]) -> str | None:
    """Return the room that a texture was taken from, as its source says; None where none."""
    named = re.findall(r"\b(?:like|of) ([^\s,]+)", str(entry.get("source", "")))
    return next((name for name in named if name in rooms), None)
