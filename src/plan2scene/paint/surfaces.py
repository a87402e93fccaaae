"""Paint of every surface of a house, observed or not (``paint.parquet``)."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from plan2scene.colour import (
    delta_e_2000,
    from_log_axes,
    is_wood,
    linear_to_srgb,
    log_axes,
    rgb_to_lab,
)
from plan2scene.house import SURFACES, SurfaceKey
from plan2scene.io import read_parquet, write_parquet
from plan2scene.paint.accents import find_accents
from plan2scene.paint.estimate import Observation, PaintPrior, estimate_paint
from plan2scene.paint.observations import WHOLE, matte_colour, usual_colour, without_glimpses

if TYPE_CHECKING:
    import pandas as pd

#: Observations of fewer pixels (share of the photo's) are left out.
LEAST_WEIGHT = 2e-5
#: If a photo taken in its room shows more of a surface, photos of other rooms are ignored for it.
OWN_WEIGHT = 2e-3
#: A white door leaf with less weight, summed over photos, is left out; chosen on two flats
#: (development).
LEAST_WHITE_DOOR = 5e-3
#: Paints that differ by less (CIEDE2000) count as one.
ONE_PAINT = 14.0
#: If at least this many rooms have walls of wood, these are one panelling. Chosen by reasoning.
PANELLED_ROOMS = 3
#: No paint reflects more, linear.
MOST_PAINT = 0.9
#: Pixels of window frames from this L* on are glass. Trim is of wood if more than this share of the
#: other pixels is: .5 on a listing with wooden windows (development), .02 on four other homes.
GLASS, LEAST_WOOD = 92.0, 0.3
#: A door leaf whose opening is not known has, for its id, this and then its photo and plane number.
UNPLACED = "?"
#: Key of the paint of frames and skirting.
TRIM = SurfaceKey("", "trim")
_COLUMNS = ["room_id", "surface", "paint", "white", "photos"]


def observations_of(path: str | Path, *, accents: bool = True) -> list[Observation]:
    """Return the usual colour of each surface and door in each photo, of ``colours.parquet``.

    With `accents` an accent wall is a surface of its own, named ``wall.`` and the ids of the walls
    on its plane, joined by ``|``.
    """
    table = without_glimpses(read_parquet(path)[0])
    table = table[table["surface"] != "frame"].copy()
    for room_id, walls in find_accents(table) if accents else ():
        accent_rows = (table["room_id"] == room_id) & (table["walls"] == walls)
        table.loc[accent_rows & (table["surface"] == "wall"), "surface"] = f"wall.{walls}"
        rest = (table["room_id"] == room_id) & (table["surface"] == "wall")
        if table.loc[rest, "weight"].sum() < WHOLE:
            table = table[~rest]  # so few pixels beside an accent may be a curtain
    doors = table["surface"] == "door"
    table["key"] = table["room_id"].where(~doors, table["walls"])
    unknown = UNPLACED + table["photo"] + "/" + table["plane"].astype(str)
    table["key"] = table["key"].where(~doors | (table["walls"] != ""), unknown)
    groups = table.groupby(["photo", "key", "surface"], sort=True)
    mixed = {photo: _mixed_light(rows) for photo, rows in table.groupby("photo")}
    observations = []
    for (photo, room_id, surface), rows in groups:
        weight = float(rows["weight"].sum())
        if weight > LEAST_WEIGHT:
            shares = [np.asarray(c, dtype=np.float64).reshape(-1, 3) for c in rows["colours"]]
            glare = surface == "floor" or surface.startswith("wall.")  # pales strong colours
            colour_of = matte_colour if glare else usual_colour
            red, green, blue = map(float, colour_of(shares, list(rows["weight"])))
            key, own = SurfaceKey(room_id, surface), bool(rows["own"].any())
            colour = red, green, blue
            observations.append(Observation(photo, key, own, weight, colour, mixed[photo]))
    photo_rooms = {item.photo: (0.0, item.photo) for item in observations}
    for item in observations:
        if item.own and item.surface.kind in SURFACES:
            weighted_room = item.weight, item.surface.room_id
            photo_rooms[item.photo] = max(photo_rooms[item.photo], weighted_room)
    observations = [replace(item, room=photo_rooms[item.photo][1]) for item in observations]
    within = {item.surface for item in observations if item.own and item.weight > OWN_WEIGHT}
    return [item for item in observations if item.own or item.surface not in within]


def _mixed_light(planes: pd.DataFrame) -> float:
    """Return how much light varies between lamp and sky in a photo, as in `Observation.mixed`.

    It is the weighted root mean square, over walls and ceilings that are seen from within their
    room, of a robust standard deviation (from the median absolute deviation).
    """
    of_room = planes[planes["surface"].isin(("wall", "ceiling")) & planes["own"]]
    if of_room.empty:
        return 0.0
    shares = np.stack([np.asarray(c, np.float64).reshape(-1, 3) for c in of_room["colours"]])
    along = log_axes(shares)[..., 1:] @ PaintPrior.lamp
    # scipy.stats has this, and takes a third of a second to import.
    away = np.abs(along - np.median(along, axis=1, keepdims=True))
    deviation = np.median(away, axis=1) / 0.6744897501960817  # of a normal distribution
    return float(np.sqrt(np.average(deviation**2, weights=of_room["weight"])))


def trim_paint(colours: str | Path, light: Mapping[str, np.ndarray]) -> np.ndarray | None:
    """Return the linear reflectance (3,) of a house's trim; None where it is not of wood.

    The colours of window frames (``colours.parquet``) are divided by the light (3,) of their photo.
    Pixels brighter than `GLASS` are left out; more than `LEAST_WOOD` of the rest has to be wood.
    """
    table, _ = read_parquet(colours)
    frames = table[(table["surface"] == "frame") & table["photo"].isin(light)]
    if frames.empty:
        return None
    frame_colours = [
        np.asarray(row.colours, np.float64).reshape(-1, 3) / light[row.photo]
        for row in frames.itertuples()
    ]
    pixels = np.repeat(frames["weight"].to_numpy(), [len(shares) for shares in frame_colours])
    paint = np.concatenate(frame_colours)
    labs = rgb_to_lab(linear_to_srgb(np.clip(paint, 0.0, 1.0)))
    opaque = labs[:, 0] < GLASS
    wood = opaque & is_wood(labs)
    if pixels[wood].sum() <= LEAST_WOOD * pixels[opaque].sum():
        return None
    return np.asarray(np.exp(np.average(np.log(paint[wood]), axis=0, weights=pixels[wood])))


def joined(
    observations: Sequence[Observation], materials: Mapping[SurfaceKey, str]
) -> tuple[list[Observation], dict[SurfaceKey, SurfaceKey]]:
    """Merge surfaces of one material; return the observations, and each surface's merged key.

    Walls and ceilings get the walls of their room as `Observation.lit_by`.
    """
    keys = sorted({item.surface for item in observations})
    first: dict[str, SurfaceKey] = {}
    owner = {key: first.setdefault(materials.get(key, "/".join(key)), key) for key in keys}
    one = []
    for item in observations:
        wall = SurfaceKey(item.surface.room_id, "wall")
        lit_by = owner.get(wall) if item.surface.kind in ("wall", "ceiling") else None
        one.append(replace(item, surface=owner[item.surface], lit_by=lit_by))
    return one, owner


def floor_materials(path: str | Path) -> dict[SurfaceKey, str]:
    """Return the name of the material of each floor, from ``materials.parquet``."""
    table, _ = read_parquet(path)
    floors = table[table["surface"] == "floor"]
    return {SurfaceKey(row.room_id, "floor"): row.material for row in floors.itertuples()}


def panelling(
    paint: Mapping[SurfaceKey, np.ndarray], white: Collection[SurfaceKey]
) -> list[SurfaceKey]:
    """Return the walls that are of wood if the house is panelled, else none.

    `paint` are linear reflectances (3,). One room gives a poor estimate: its photos also show
    lamps, and beds of the same wood. A house has one panelling: its paint is these walls' median.
    """
    walls = [key for key in sorted(paint) if key.surface == "wall" and key not in white]
    levels = [linear_to_srgb(np.minimum(paint[key], 1.0)) for key in walls]
    wood = [key for key, level in zip(walls, levels, strict=True) if is_wood(rgb_to_lab(level))]
    return wood if len(wood) >= PANELLED_ROOMS else []


def write_paint(
    colours: str | Path,
    materials: str | Path,
    output: str | Path,
    *,
    dataset: str,
    house: str,
    accents: bool = True,
) -> None:
    """Estimate the paint of a house from ``colours.parquet``; write ``paint.parquet``.

    Floors that share a material (``materials.parquet``) have one paint, and so have the walls of a
    :func:`panelling`. Other walls and ceilings each have a paint of their own, even if they seem to
    share a material. `accents` is that of :func:`observations_of`.

    The file has a row for each observed surface: ``room_id (of a door the id of its opening, or
    `UNPLACED`), surface, paint (3 floats, linear reflectance), white (bool), photos (names joined
    by |)``, and a row `TRIM` if frames and skirting are of wood.
    """
    import pandas as pd

    observations = observations_of(colours, accents=accents)
    one, owner = joined(observations, floor_materials(materials))
    estimate = estimate_paint(one)
    paint = dict(estimate.paint)
    if panels := panelling(paint, estimate.white):
        panel_paint = np.exp(np.median([np.log(paint[key]) for key in panels], axis=0))
        paint |= dict.fromkeys(panels, panel_paint)
    photos: dict[SurfaceKey, list[str]] = {}
    shares: dict[SurfaceKey, float] = {}
    for item in observations:
        photos.setdefault(item.surface, []).append(item.photo)
        shares[item.surface] = shares.get(item.surface, 0.0) + item.weight
    rows = [
        {
            "room_id": key.room_id,
            "surface": surface,
            "paint": np.minimum(paint[same], MOST_PAINT).tolist(),
            "white": same in estimate.white,
            "photos": "|".join(photos[key]),
        }
        for key, same in owner.items()
        for surface in _each(key)
        # A few white pixels in a doorway may be its frame or the wall behind it.
        if key.surface != "door" or same not in estimate.white or shares[key] >= LEAST_WHITE_DOOR
    ]
    trim = trim_paint(colours, estimate.light)
    if trim is not None:
        rows.append({**TRIM._asdict(), "paint": trim.tolist(), "white": False, "photos": ""})
    metadata = {"dataset": dataset, "house": house}
    write_parquet(output, pd.DataFrame(rows, columns=_COLUMNS), metadata)


def _each(key: SurfaceKey) -> list[str]:
    """Return the kind of a surface; of an accent, ``wall.{id}`` for each wall on its plane."""
    kind, _, walls = key.surface.partition(".")
    return [f"wall.{name}" for name in walls.split("|")] if walls else [kind]


def read_paint(path: str | Path) -> tuple[dict[SurfaceKey, np.ndarray], frozenset[SurfaceKey]]:
    """Return the linear reflectance (3,) of the observed surfaces, and which of them are white."""
    table, _ = read_parquet(path)
    paint = {
        SurfaceKey(row.room_id, row.surface): np.asarray(row.paint, dtype=np.float64)
        for row in table.itertuples()
    }
    white = zip(paint, table["white"], strict=True)
    return paint, frozenset(key for key, is_white in white if is_white)


def read_seen_photos(path: str | Path) -> dict[SurfaceKey, list[str]]:
    """Return the photos that show each observed surface, of ``paint.parquet``."""
    table, _ = read_parquet(path)
    return {SurfaceKey(r.room_id, r.surface): r.photos.split("|") for r in table.itertuples()}


def paint_gains(
    shown: Mapping[SurfaceKey, np.ndarray],
    paint: Mapping[SurfaceKey, np.ndarray],
    whites: Collection[SurfaceKey],
    usual_white: Sequence[float],
    guessed: Collection[SurfaceKey] = (),
) -> dict[SurfaceKey, np.ndarray]:
    """Return the factors (3,) on linear RGB that give the texture of each surface its paint.

    A surface of known paint gets that paint; those in `whites` get white. Each other surface gets
    the factor of the most similar texture of known paint, of its own kind if there is one. This
    factor is the light of photos, so textures that show crops of their own surface, those that are
    not `guessed`, come first. `shown` is the linear RGB (3,) of each texture, `usual_white` the
    linear reflectance (3,) of white paint; `paint` is as from :func:`read_paint`.
    """
    factors = {key: paint[key] / shown[key] for key in shown if key in paint}
    gains = {}
    for key in shown:
        if key in factors:
            gains[key] = factors[key]
            continue
        of_kind = [other for other in factors if other.surface == key.surface]
        observed = [other for other in of_kind if other not in guessed] or of_kind
        if key in whites:
            gains[key] = np.asarray(usual_white) / shown[key]
        else:
            gains[key] = (
                factors[_alike(shown, key, observed or list(factors))] if factors else np.ones(3)
            )
    return gains


def plain_whites(
    paint: Mapping[SurfaceKey, np.ndarray],
    white: frozenset[SurfaceKey],
    unseen: Iterable[SurfaceKey],
    open_air: Collection[str] = (),
) -> set[SurfaceKey]:
    """Return which walls and ceilings of the `unseen` are white.

    `paint` and `white` are as from :func:`read_paint`. A surface of unknown paint is white, unless
    more than half of the known surfaces of its kind, and at least two, share one paint that is not
    white, as in a panelled house. Rooms in the `open_air` (ids) do not count.
    """
    whites = set()
    indoors = [other for other in paint if other.room_id not in open_air]
    for key in unseen:
        known = [other for other in indoors if other.surface == key.surface]
        if key.surface not in ("wall", "ceiling"):
            continue
        if key in paint:
            is_white = key in white
        else:
            group = _commonest([paint[other] for other in known])
            is_white = 2 * len(group) <= max(2, len(known)) or known[group[0]] in white
        if is_white:
            whites.add(key)
    return whites


def grey_floor(predicted: np.ndarray) -> np.ndarray:
    """Return the paint (3,) of a floor of stone or carpet whose colour is only predicted.

    It has the hue of pale floors and the brightness of `predicted` (3,), linear RGB, clipped to
    between a usual dark floor and white: a prediction alone does not justify a pink bathroom.
    """
    mean, deviation = (axes[0] for axes in (PaintPrior.pale, PaintPrior.pale_deviation))
    bright = np.clip(log_axes(predicted)[0], mean[0] - deviation[0], PaintPrior.white[0])
    return from_log_axes(np.array([bright, *mean[1:]]))


def _commonest(paints: Sequence[np.ndarray]) -> list[int]:
    """Return the indices of the largest group of paints (3,) near one of them, that one first."""
    if not paints:
        return []
    labs = rgb_to_lab(linear_to_srgb(np.array(paints)))
    apart = delta_e_2000(labs[:, None], labs[None])
    nearest = apart[int((apart < ONE_PAINT).sum(axis=1).argmax())]
    return [int(k) for k in np.argsort(nearest, kind="stable") if nearest[k] < ONE_PAINT]


def _alike(
    shown: Mapping[SurfaceKey, np.ndarray], one: SurfaceKey, others: Sequence[SurfaceKey]
) -> SurfaceKey:
    """Return the one of `others` whose texture has the log colour nearest to that of `one`."""
    target = log_axes(shown[one])
    away = [float(np.linalg.norm(log_axes(shown[other]) - target)) for other in others]
    return others[int(np.argmin(away))]


def door_paints(
    paint: Mapping[SurfaceKey, np.ndarray], white: frozenset[SurfaceKey]
) -> dict[str, np.ndarray]:
    """Return the linear reflectance (3,) of door leaves by the id of their opening.

    The largest group of coloured leaves of about one paint gets its mean. The id "" stands for all
    doors that no photo shows: they get the median of the coloured doors, if these outnumber the
    white ones by at least two. Otherwise there is no "", and these doors are white.
    """
    doors = {key.room_id: value for key, value in paint.items() if key.surface == "door"}
    names = [name for name in doors if SurfaceKey(name, "door") not in white]
    alike_doors = [names[k] for k in _commonest([doors[name] for name in names])]
    if alike_doors:
        one = np.asarray(np.exp(np.mean([np.log(doors[name]) for name in alike_doors], axis=0)))
        doors |= dict.fromkeys(alike_doors, one)
    coloured = 2 * len(names) >= len(doors) + 2
    placed = {name: value for name, value in doors.items() if not name.startswith(UNPLACED)}
    return placed | ({"": np.median([doors[name] for name in names], axis=0)} if coloured else {})
