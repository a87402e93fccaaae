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
#: A surface of which a photo taken in its room shows more takes no colour from other rooms' photos.
OWN_WEIGHT = 2e-3
#: A white door leaf has at least this share of photos, together; chosen on two flats (development).
LEAST_WHITE_DOOR = 5e-3
#: Paints that differ by less (CIEDE2000) are about one.
ONE_PAINT = 14.0
#: From so many rooms on whose walls are of wood these are one panelling, by reasoning.
PANELLED_ROOMS = 3
#: No paint reflects more, linear.
MOST_PAINT = 0.9
#: L* from which on what is seen beside a window's frame is glass, and the share of the rest that is
#: wood where trim is: .5 on a listing with wooden windows (development), .02 on four other homes.
GLASS, LEAST_WOOD = 92.0, 0.3
#: Before photo and number of a door leaf whose opening is not known, in place of its id.
UNPLACED = "?"
#: Key of the paint of frames and skirting.
TRIM = SurfaceKey("", "trim")
_COLUMNS = ["room_id", "surface", "paint", "white", "photos"]


def observations_of(path: str | Path, *, accents: bool = True) -> list[Observation]:
    """Return the usual colour of each surface and door in each photo, of ``colours.parquet``.

    With `accents` walls of another paint than their room's are surfaces of their own: ``wall.``
    and the ids of those on one plane, joined by ``|``.
    """
    table = without_glimpses(read_parquet(path)[0])
    table = table[table["surface"] != "frame"].copy()
    for room_id, walls in find_accents(table) if accents else ():
        mine = (table["room_id"] == room_id) & (table["walls"] == walls)
        table.loc[mine & (table["surface"] == "wall"), "surface"] = f"wall.{walls}"
        rest = (table["room_id"] == room_id) & (table["surface"] == "wall")
        if table.loc[rest, "weight"].sum() < WHOLE:
            table = table[~rest]  # what little is seen beside an accent may be a curtain
    doors = table["surface"] == "door"
    table["key"] = table["room_id"].where(~doors, table["walls"])
    unknown = UNPLACED + table["photo"] + "/" + table["plane"].astype(str)
    table["key"] = table["key"].where(~doors | (table["walls"] != ""), unknown)
    groups = table.groupby(["photo", "key", "surface"], sort=True)
    mixed = {photo: _mixed_light(rows) for photo, rows in table.groupby("photo")}
    found = []
    for (photo, room_id, surface), rows in groups:
        weight = float(rows["weight"].sum())
        if weight > LEAST_WEIGHT:
            shares = [np.asarray(c, dtype=np.float64).reshape(-1, 3) for c in rows["colours"]]
            glare = surface == "floor" or surface.startswith("wall.")  # pales strong colours
            colour_of = matte_colour if glare else usual_colour
            red, green, blue = map(float, colour_of(shares, list(rows["weight"])))
            key, own = SurfaceKey(room_id, surface), bool(rows["own"].any())
            colour = red, green, blue
            found.append(Observation(photo, key, own, weight, colour, mixed[photo]))
    taken = {item.photo: (0.0, item.photo) for item in found}
    for item in found:
        if item.own and item.surface.kind in SURFACES:
            here = item.weight, item.surface.room_id
            taken[item.photo] = max(taken[item.photo], here)
    found = [replace(item, room=taken[item.photo][1]) for item in found]
    within = {item.surface for item in found if item.own and item.weight > OWN_WEIGHT}
    return [item for item in found if item.own or item.surface not in within]


def _mixed_light(planes: pd.DataFrame) -> float:
    """Return how much light varies between lamp and sky in a photo, as in `Observation.mixed`.

    The deviation of the middle half (median absolute deviation) on each wall and ceiling that is
    seen from within its room.
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

    Frames of windows tell it (``colours.parquet``), each in the light (3,) of its photo. What is
    brighter than white paint is glass; enough of the rest has to be wood.
    """
    table, _ = read_parquet(colours)
    frames = table[(table["surface"] == "frame") & table["photo"].isin(light)]
    if frames.empty:
        return None
    shown = [
        np.asarray(row.colours, np.float64).reshape(-1, 3) / light[row.photo]
        for row in frames.itertuples()
    ]
    pixels = np.repeat(frames["weight"].to_numpy(), [len(shares) for shares in shown])
    paint = np.concatenate(shown)
    labs = rgb_to_lab(linear_to_srgb(np.clip(paint, 0.0, 1.0)))
    opaque = labs[:, 0] < GLASS
    wood = opaque & is_wood(labs)
    if pixels[wood].sum() <= LEAST_WOOD * pixels[opaque].sum():
        return None
    return np.asarray(np.exp(np.average(np.log(paint[wood]), axis=0, weights=pixels[wood])))


def joined(
    observations: Sequence[Observation], materials: Mapping[SurfaceKey, str]
) -> tuple[list[Observation], dict[SurfaceKey, SurfaceKey]]:
    """Return observations in which surfaces of one material are one, and whose paint each has.

    Walls of their room light walls and ceilings.
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
    """Return which floors share a material, of ``materials.parquet``."""
    table, _ = read_parquet(path)
    floors = table[table["surface"] == "floor"]
    return {SurfaceKey(row.room_id, "floor"): row.material for row in floors.itertuples()}


def panelling(
    paint: Mapping[SurfaceKey, np.ndarray], white: Collection[SurfaceKey]
) -> list[SurfaceKey]:
    """Return the walls of wood of a panelled house, of linear reflectances (3,); else none.

    Pixels of one room tell little of it: lamps, beds and bunks of the same wood are in the photos.
    A house has one panelling, so that the median of its walls tells its paint.
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
    """Estimate the paint of a house of ``colours.parquet``; write ``paint.parquet``.

    Floors that share a material (``materials.parquet``) have one paint, as have walls of one
    :func:`panelling`; other walls and ceilings are told apart by their light, not by the material
    that they seem to share. `accents` are as of :func:`observations_of`.

    A row for each observed surface: ``room_id (of a door the id of its opening, or `UNPLACED`),
    surface, paint (3 floats, linear reflectance), white (bool), photos (names joined by |)``. One
    of `TRIM` where frames and skirting are of wood.
    """
    import pandas as pd

    observations = observations_of(colours, accents=accents)
    one, owner = joined(observations, floor_materials(materials))
    estimate = estimate_paint(one)
    paint = dict(estimate.paint)
    if panels := panelling(paint, estimate.white):
        usual = np.exp(np.median([np.log(paint[key]) for key in panels], axis=0))
        paint |= dict.fromkeys(panels, usual)
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
        # A little white in a doorway may be its frame or the wall behind it.
        if key.surface != "door" or same not in estimate.white or shares[key] >= LEAST_WHITE_DOOR
    ]
    trim = trim_paint(colours, estimate.light)
    if trim is not None:
        rows.append({**TRIM._asdict(), "paint": trim.tolist(), "white": False, "photos": ""})
    metadata = {"dataset": dataset, "house": house}
    write_parquet(output, pd.DataFrame(rows, columns=_COLUMNS), metadata)


def _each(key: SurfaceKey) -> list[str]:
    """Return the surface, or ``wall.{id}`` of each accent wall on one plane."""
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
) -> dict[SurfaceKey, np.ndarray]:
    """Return the factors (3,) that take the textures of all surfaces to their paint.

    A surface whose paint is known gets it. Those that `plain_whites` names are white. Others get
    the factor of a known one of their kind, or of all, whose texture looks most alike.

    Parameters
    ----------
    shown : dict of SurfaceKey to (3,) float
        Linear RGB of the texture of each surface.
    paint
        As of :func:`read_paint`.
    whites
        Of :func:`plain_whites`.
    usual_white : (3,) float
        Linear reflectance of white paint.
    """
    own = {key: paint[key] / shown[key] for key in shown if key in paint}
    gains = {}
    for key in shown:
        if key in own:
            gains[key] = own[key]
            continue
        observed = [other for other in own if other.surface == key.surface]
        if key in whites:
            gains[key] = np.asarray(usual_white) / shown[key]
        else:
            gains[key] = own[_alike(shown, key, observed or list(own))] if own else np.ones(3)
    return gains


def plain_whites(
    paint: Mapping[SurfaceKey, np.ndarray],
    white: frozenset[SurfaceKey],
    unseen: Iterable[SurfaceKey],
    open_air: Collection[str] = (),
) -> set[SurfaceKey]:
    """Return which walls and ceilings of the `unseen` are white, as of :func:`read_paint`.

    A strong colour stays in the rooms that show it: what no photo shows has the paint of most known
    surfaces of its kind where most have about one, as panelled rooms do; else it is white. Rooms in
    the `open_air` (ids) have no say.
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
    """Return the paint (3,) of a floor of stone or carpet that nothing in the house tells of.

    It has the hue of pale floors and the brightness of what is `predicted` (3,), linear RGB, from
    a usual dark one to white: a prediction alone is no ground for a pink bathroom.
    """
    mean, deviation = (axes[0] for axes in (PaintPrior.pale, PaintPrior.pale_deviation))
    bright = np.clip(log_axes(predicted)[0], mean[0] - deviation[0], PaintPrior.white[0])
    return from_log_axes(np.array([bright, *mean[1:]]))


def _commonest(paints: Sequence[np.ndarray]) -> list[int]:
    """Return the largest group of paints (3,) that look like one of them, that one first."""
    if not paints:
        return []
    labs = rgb_to_lab(linear_to_srgb(np.array(paints)))
    apart = delta_e_2000(labs[:, None], labs[None])
    nearest = apart[int((apart < ONE_PAINT).sum(axis=1).argmax())]
    return [int(k) for k in np.argsort(nearest, kind="stable") if nearest[k] < ONE_PAINT]


def _alike(
    shown: Mapping[SurfaceKey, np.ndarray], one: SurfaceKey, others: Sequence[SurfaceKey]
) -> SurfaceKey:
    """Return the surface whose texture's log colour is nearest."""
    target = log_axes(shown[one])
    away = [float(np.linalg.norm(log_axes(shown[other]) - target)) for other in others]
    return others[int(np.argmin(away))]


def door_paints(
    paint: Mapping[SurfaceKey, np.ndarray], white: frozenset[SurfaceKey]
) -> dict[str, np.ndarray]:
    """Return the linear reflectance (3,) of door leaves by the id of their opening.

    Coloured leaves of about one paint are one material. The id "" stands for all doors that no
    photo shows: they are like the others where at least two more are coloured than white. There is
    none where they are white.
    """
    doors = {key.room_id: value for key, value in paint.items() if key.surface == "door"}
    names = [name for name in doors if SurfaceKey(name, "door") not in white]
    alike = [names[k] for k in _commonest([doors[name] for name in names])]
    if alike:
        one = np.asarray(np.exp(np.mean([np.log(doors[name]) for name in alike], axis=0)))
        doors |= dict.fromkeys(alike, one)
    usual = 2 * len(names) >= len(doors) + 2
    placed = {name: value for name, value in doors.items() if not name.startswith(UNPLACED)}
    return placed | ({"": np.median([doors[name] for name in names], axis=0)} if usual else {})
