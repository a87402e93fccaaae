"""Textures of a house in the colours of its paint: what the 3D house shows.

Tiles and maps are made in the colours of the photos, which include the photos' light. A viewer
lights the house again, so its textures must hold the paint alone.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from plan2scene.colour import (
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
from plan2scene.materials.periodic_noise import blur
from plan2scene.mesh.texture_files import texture_index
from plan2scene.paint.estimate import PaintPrior
from plan2scene.paint.light import repainted
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

_QUALITY = 85  #: JPEG quality of repainted maps
#: Linear value above which brightened values bend, so that none burns out. It is above white paint.
_KNEE = 0.88
#: A pattern on a white surface with a smaller standard deviation of log brightness is grain or
#: relief. Plain walls of real and synthetic homes (development) have .006 to .027; tiles, wallpaper
#: and rough ceilings have .03 to .06.
FAINT = 0.028
#: A stronger pattern on a white surface is a blind, a picture or a splashback: .18 and .20 in a
#: real listing (development). Tiles and curtains have .06 at most.
LOUD = 0.12
#: A pattern on a white wall shows folds of curtains, corners or edges of light if more than the
#: first share of its variance is constant from top to bottom, and less than the second from side to
#: side: .38 to .8 and 0 to .12 in three real homes (development). For tiles both are above .26.
UPRIGHT = (0.3, 0.15)
PATTERNED = ("tile", "wood")  #: Substances whose patterns are not stains
_BLACK = 1e-3  #: Least linear value of a texture's median
#: Carpets with weaker :func:`stains` have no pattern, only wear and light: .005 to .05 in three
#: real homes (development). The faint dots of a carpet in the demo have .10.
PLAIN_CARPET = 0.07
#: Linear RGB and substance of unseen floors and walls of balconies, terraces and yards, since
#: carpets and wallpapers stay indoors: grey stone (also for unseen garage floors) and render.
OUTDOORS = {
    "floor": (np.full(3, 0.30), "tile"),
    "wall": (srgb_to_linear(np.array(RENDER, np.uint8)), "plaster"),
}
#: Mean CIEDE2000 to the true material of floors, walls and ceilings, seen and unseen, and of walls
#: or ceilings seen to be coloured. 43 synthetic homes, 60 % of their photos hidden (development).
SEEN, UNSEEN, COLOURED = (8.3, 6.2, 2.6), (16.1, 11.9, 2.6), 12.9
DOUBTFUL = 10.0  #: Least expected error, CIEDE2000, that is mentioned to people


@dataclass(frozen=True)
class PlainSettings:
    """What is light and noise on plain paint. Chosen by looking at a real flat (development).

    White paint has one colour. Slow variations over a white wall are light, and faint colours in
    its grain are the noise of a dim photo. Relief and coloured patterns are kept.
    """

    slow_m: float = 0.1  #: sigma, metres, of the blur that is subtracted to measure a pattern
    smear_m: float = 0.03  #: sigma, metres, of the blur that holds light, smears and lens dirt
    #: Largest deviation of log brightness that is kept, in median deviations of the paint's grain
    #: and relief. A larger one is a nail, a hook or a crack, which a tile must not repeat.
    relief: float = 4.5
    noise: float = 0.06  #: weaker colours (log red or blue against green) are noise
    brightest: float = 0.95  #: largest linear value of a plain tile


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

    The folder has the files of `textures`, without maps of plain white surfaces and plain carpets
    (their tile shows everything). It adds ``doors.json``, sRGB levels of door leaves by the id of
    their opening, and ``trim.json``, those of frames and skirting where these are of wood. An
    accent wall has its room's pattern in its own paint; walls of one panelling have one pattern.
    Surfaces that no photo shows: white walls take no pattern from another room; floors and walls of
    `bathrooms` (room ids) are like another bathroom's; floors of the rooms `uncarpeted` are no
    carpet; floors and walls of rooms in the `open_air` are of stone and render, floors of `garages`
    of stone. `last_word` may change the finished folder before it is moved to `out_dir`.
    """
    root = Path(textures)
    entry_by_name = texture_index(root)
    entries = {SurfaceKey(*name.rsplit("/", 1)): entry for name, entry in entry_by_name.items()}
    tiles = {key: read_image(root / f"{key.filename}.png") for key in entries}
    paints, white_surfaces = read_paint(paint)
    for key in paints:
        room_key = SurfaceKey(key.room_id, key.kind)
        if key != room_key and room_key in entries and ID_PATTERN.fullmatch(key.surface):
            tiles[key], entries[key] = tiles[room_key], entries[room_key] | {"observed": True}
            if room_key not in paints:  # the room's crops show the accent wall only
                entries[room_key] = entries[room_key] | {"observed": False}
    unseen = {key for key, entry in entries.items() if entry.get("observed") is False}
    stand_ins = _other_bathrooms(bathrooms, entries, paints)
    stand_ins |= _without_carpet(uncarpeted, bathrooms, entries, paints)
    unseen -= stand_ins.keys()
    whites = plain_whites(paints, white_surfaces, unseen, open_air)  # decided by what photos show
    panels = _one_panelling(entries, paints, white_surfaces, unseen - paints.keys() - whites)
    for key, other in panels.items():
        tiles[key], paints[key] = tiles[other], paints[other]
        entries[key] = entries[other] | {"observed": key not in unseen}
        entries[key]["source"] = f"panelling, like {other.room_id}"
    for key, other in stand_ins.items():
        tiles[key], paints[key] = tiles[other], paints[other]
        source = f"as the use of the room asks, like {other.room_id}"
        entries[key] = entries[other] | {"observed": False, "source": source}
    white_surfaces |= {key for key, other in stand_ins.items() if other in white_surfaces}
    tile_colours = {
        key: np.maximum(srgb_to_linear(median_colour(tile)), _BLACK) for key, tile in tiles.items()
    }
    white = np.exp(PaintPrior().white[0]) * np.ones(3)
    gains = paint_gains(tile_colours, paints, whites, white, unseen)
    photos, rooms = read_seen_photos(paint), {key.room_id for key in entries}
    for key in unseen - paints.keys():
        stone = key.kind == "floor" and entries[key].get("substance") != "wood"
        if stone and _room_of_source(entries[key], rooms) is None:
            gains[key] = grey_floor(gains[key] * tile_colours[key]) / tile_colours[key]
    doors = {
        name: as_uint8(linear_to_srgb(colour)).tolist()
        for name, colour in door_paints(paints, white_surfaces).items()
    }
    trim = {"": as_uint8(linear_to_srgb(paints[TRIM])).tolist()} if TRIM in paints else {}
    if trim and not doors:  # unseen doors are like the rest of the joinery
        doors = dict(trim)
    has_maps = (root / "maps.json").is_file()
    maps = read_stage_json(root / "maps.json", "maps") if has_maps else {"surfaces": {}}
    plains = _plain_tiles(tiles, gains, entries, white_surfaces | whites, whites)
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
            bare = plains[key].image if key in plains else repainted(tile, gains[key], knee=_KNEE)
            write_png(folder / f"{key.filename}.png", bare)
            whole = root / f"{key.filename}.jpg"
            if whole.is_file() and key not in plains.keys() | stand_ins.keys() | panels.keys():
                lit = repainted(read_image(whole), gains[key], knee=_KNEE)
                (folder / whole.name).write_bytes(jpeg_bytes(lit, quality=_QUALITY))
        write_json(folder / "doors.json", doors)
        if trim:
            write_json(folder / "trim.json", trim)
        facts = {
            "/".join(key): {"size_m": plain_tile.size_m, "substance": plain_tile.substance}
            for key, plain_tile in plains.items()
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
            gone = facts.keys() | {"/".join(key) for key in stand_ins.keys() | panels.keys()}
            kept = {name: e for name, e in maps["surfaces"].items() if name not in gone}
            write_json(folder / "maps.json", maps | {"surfaces": kept})
        if last_word is not None:
            last_word(folder)


def _other_bathrooms(
    bathrooms: Collection[str],
    entries: Mapping[SurfaceKey, Mapping[str, Any]],
    paints: Mapping[SurfaceKey, np.ndarray],
) -> dict[SurfaceKey, SurfaceKey]:
    """Return, for each unseen floor or wall of a bathroom, one of another bathroom that is seen.

    Those with crops come first. Surfaces whose texture was taken from a bathroom are left out.
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
    """Return, for each unseen carpet of rooms `uncarpeted`, a floor with crops that is no carpet.

    Floors of other such rooms come first, those of bathrooms last. Empty if there is no such floor.
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
    """Return, for each other wall of a :func:`panelling`, the seen wall whose tile is largest.

    `unseen` walls, which are not white, belong to the panelling, too.
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
    """A tile (n, n, 3) uint8 sRGB, the metres of its side, how strong its pattern is."""

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

    Surfaces that are `unseen`, or whose crops show things, are made plain, too: unless their own
    pattern is faint, they get the plainest tile of their kind or, without one, a single colour.
    """
    plain_tiles, bare = {}, {}
    handed_on = set(unseen)
    for key in sorted(tiles.keys() & set(white)):
        if key.kind in ("wall", "ceiling"):
            image, size_m = tiles[key], float(entries[key]["size_m"])
            colour = gains[key] * srgb_to_linear(median_colour(image))
            image, pattern = plain(image, colour, len(image) / size_m)
            plain_tiles[key] = _Tile(image, size_m, entries[key].get("substance"), pattern)
            plainer = key.kind == "wall" and plain_tiles[key].substance not in PATTERNED
            if pattern > LOUD or (plainer and pattern >= FAINT and is_upright(tiles[key], size_m)):
                handed_on.add(key)
            bare[key] = np.full_like(image, as_uint8(linear_to_srgb(np.minimum(colour, 1.0))))
    plainest: dict[str, _Tile] = {}
    for key, tile in sorted(plain_tiles.items(), key=lambda item: item[1].pattern):
        if key not in handed_on and tile.substance not in PATTERNED:
            plainest.setdefault(key.surface, tile)
    return {
        key: tile
        if tile.pattern < FAINT
        else plainest.get(key.surface, replace(tile, image=bare[key], pattern=0.0))
        for key, tile in plain_tiles.items()
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
            px_per_m = len(tiles[key]) / size_m
            image = repainted(tiles[key], gains[key], knee=_KNEE)
            if stains(image, px_per_m) < PLAIN_CARPET:
                image, pattern = plain(image, srgb_to_linear(median_colour(image)), px_per_m)
                made[key] = _Tile(image, size_m, "carpet", pattern)
    return made


def _open_air_tiles(
    tiles: Mapping[SurfaceKey, np.ndarray], entries: Mapping[SurfaceKey, Mapping[str, Any]]
) -> dict[SurfaceKey, _Tile]:
    """Return tiles in the colours of `OUTDOORS`, with the grain of `tiles` where it is faint."""
    made = {}
    for key, tile in tiles.items():
        colour, substance = OUTDOORS[key.kind]
        size_m = float(entries[key]["size_m"])
        image, pattern = plain(tile, colour, len(tile) / size_m)
        if pattern > FAINT:  # joints, folds: not those of stone and render
            image = np.full_like(image, as_uint8(linear_to_srgb(colour)))
        made[key] = _Tile(image, size_m, substance, pattern)
    return made


def plain(image: np.ndarray, colour: np.ndarray, px_per_m: float) -> tuple[np.ndarray, float]:
    """Return a tile in one paint with its relief, and how strong its pattern is.

    `image` and the tile are (h, w, 3) uint8 sRGB, `colour` (3,) is the paint in linear RGB; the
    strength is the standard deviation of log brightness.
    """
    axes = log_axes(srgb_to_linear(image)).astype(np.float32)
    pattern = float((axes - blur(axes, _PLAIN.slow_m * px_per_m))[..., 0].std())
    detail = axes - blur(axes, _PLAIN.smear_m * px_per_m)
    faint = np.clip(detail[..., 1:], -_PLAIN.noise, _PLAIN.noise)
    detail[..., 1:] -= faint
    detail[..., 0] -= np.median(detail[..., 0])
    relief_limit = _PLAIN.relief * float(np.median(np.abs(detail[..., 0])))
    detail[..., 0] = np.clip(detail[..., 0], -relief_limit, relief_limit)
    linear = from_log_axes(log_axes(np.asarray(colour)) + detail)
    painted = as_uint8(linear_to_srgb(np.minimum(linear, _PLAIN.brightest)))
    return painted, pattern


def stains(image: np.ndarray, px_per_m: float) -> float:
    """Return how much a texture (h, w, 3) uint8 sRGB varies over centimetres.

    The standard deviation of its log colours between `PlainSettings.smear_m` and `slow_m`.
    """
    axes = log_axes(srgb_to_linear(image)).astype(np.float32)
    smeared, slow = (blur(axes, m * px_per_m) for m in (_PLAIN.smear_m, _PLAIN.slow_m))
    return float(np.sqrt((smeared - slow).var(axis=(0, 1)).sum()))


def is_upright(image: np.ndarray, size_m: float) -> bool:
    """Return whether the pattern of a tile (h, w, 3) uint8 sRGB runs from top to bottom alone."""
    axes = log_axes(srgb_to_linear(image)).astype(np.float32)[..., :1]
    pattern = (axes - blur(axes, _PLAIN.slow_m * len(image) / size_m).reshape(axes.shape))[..., 0]
    upright, level = (float(pattern.mean(axis=axis).var()) for axis in (0, 1))
    varies = float(pattern.var())
    return upright > UPRIGHT[0] * varies and level < UPRIGHT[1] * varies


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

    ``like`` is the room that its texture was taken from, the error that of :func:`expected_error`.

    `entry` is its entry in ``textures.json``, `photos` are those that show its colour, `rooms` the
    ids of the house's rooms. `white`: it is white because most known surfaces of its kind are.
    """
    like = _room_of_source(entry, rooms)
    observed = entry.get("observed") is not False
    room = None if observed or white else like
    count = f"{len(photos)} photo{'s' if len(photos) != 1 else ''}"
    if observed:
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
    """Return the room that a texture was taken from, by its source; None if there is none."""
    named = re.findall(r"\b(?:like|of) ([^\s,]+)", str(entry.get("source", "")))
    return next((name for name in named if name in rooms), None)
