"""Accent walls: a wall of another paint than the other walls of its room.

Photos with a known camera pose tell the walls of a room apart. Light differs from wall to wall,
most of all in brightness and between lamp and sky. So a wall is an accent only if, in photos that
show it together with other walls, its colour differs from theirs by more than light explains.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plan2scene.colour import is_wood, linear_to_srgb, log_axes, rgb_to_lab
from plan2scene.paint.estimate import PaintPrior
from plan2scene.paint.observations import usual_colour

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class AccentSettings:
    """When a wall counts as an accent."""

    #: Standard deviations of light between the walls of a room in one photo, natural logs: of
    #: brightness, of hue along `PaintPrior.lamp`, of hue across it. Measured on white walls of two
    #: real flats (development).
    light: tuple[float, float, float] = (0.5, 0.17, 0.07)
    #: Least difference of an accent from the other walls, in standard deviations: if several photos
    #: show it, if one does, and if one does and its colour is that of wood (it may be a cupboard
    #: that the mask takes for wall). Chosen on 13 synthetic homes, the demo and two real flats.
    apart: float = 4.5
    alone: float = 6.0
    wooden: float = 10.0
    #: An accent is seen less (by weight) than the other walls; up to `most` times as much if it is
    #: darker by `dark` standard deviations or its colour is `stronger` times as strong as theirs.
    dark: float = 3.0
    stronger: float = 2.0
    most: float = 8.0
    #: Least weight (``colours.parquet``) of an accent, and of the other walls, in a photo of both.
    least: float = 0.01
    #: If more than this share of the other walls has the colour, it is a band around the room.
    band: float = 0.05


_S = AccentSettings()
_LAMP = PaintPrior().lamp


def find_accents(table: pd.DataFrame) -> list[tuple[str, str]]:
    """Return room and `walls` (ids on one plane, joined by ``|``) of the accents of a house.

    If photos show only one wall plane of a room and its colour is strong, this plane is an accent.
    `table` holds rows of ``colours.parquet``.
    """
    wall_rows = table[(table["surface"] == "wall") & table["own"]]
    seen = wall_rows[wall_rows["walls"] != ""]
    accents = []
    for room_id, of_room in seen.groupby("room_id", sort=True):
        whole = wall_rows[(wall_rows["room_id"] == room_id) & (wall_rows["weight"] >= _S.least)]
        if len(only := set(whole["walls"])) == 1 and "" not in only:
            other_room_rows = wall_rows[wall_rows["room_id"] != room_id]
            usual_strength = _strength(other_room_rows) if len(other_room_rows) else 0.0
            if _strength(whole) > max(_S.alone, _S.stronger * usual_strength):
                accents.append((str(room_id), only.pop()))
                continue
        while (walls := _strongest(of_room)) is not None:
            # Compare the other walls without it: a white wall differs as much from a red one.
            of_room = of_room[of_room["walls"] != walls]
            accents.append((str(room_id), walls))
    return accents


def _strongest(of_room: pd.DataFrame) -> str | None:
    """Return the accent walls with the strongest colour in a room; None if there is none."""
    strength: dict[str, float] = {}
    for walls, plane_rows in of_room.groupby("walls", sort=True):
        other_rows = of_room[of_room["walls"] != walls]
        both = list(_differences(plane_rows, other_rows))
        wooden = _is_wood(plane_rows)
        if not both or (wooden and _is_wood(other_rows)):  # one panelling, in light and shade
            continue
        weights, away = (np.array(part) for part in zip(*both, strict=True))
        mean = np.average(away, axis=0, weights=weights.min(axis=1) ** 0.5)
        length = float(np.linalg.norm(mean))
        # If photos contradict each other, one is misplaced, or shows a door or a cupboard.
        agree = float(np.quantile(away @ mean / length**2, 0.5, method="lower")) if length else 0.0
        least = _S.apart
        if len(both) == 1:
            least = _S.wooden if wooden else _S.alone
        own, others = weights.sum(axis=0)
        own_strength = _strength(plane_rows)
        strong = mean[0] < -_S.dark or own_strength > _S.stronger * _strength(other_rows)
        rare = own < (_S.most if strong else 1.0) * others
        if rare and min(agree, 1.0) * length >= least:
            strength[str(walls)] = own_strength
    return max(strength, key=lambda walls: strength[walls], default=None)


def _differences(
    mine: pd.DataFrame, rest: pd.DataFrame
) -> Iterator[tuple[tuple[float, float], np.ndarray]]:
    """Yield, for each photo of `mine` and `rest`, their weights and their colour difference (3,).

    It is in standard deviations (`AccentSettings.light`), and 0 if `rest` has the colour as a band.
    """
    for photo, own_rows in mine.groupby("photo", sort=True):
        others = rest[rest["photo"] == photo]
        weights = float(own_rows["weight"].sum()), float(others["weight"].sum())
        if min(weights) >= _S.least:
            own_colour, other_colour = _scaled(_usual(own_rows)), _scaled(_usual(others))
            shares = _scaled(np.concatenate([_colours(c) for c in others["colours"]]))
            like_own = (
                np.linalg.norm(shares - own_colour, axis=1)
                < np.linalg.norm(own_colour - other_colour) / 2
            )
            of = np.repeat(others["weight"].to_numpy(), len(shares) // len(others))
            band = np.average(like_own, weights=of) > _S.band
            yield weights, np.zeros(3) if band else own_colour - other_colour


def _scaled(linear: np.ndarray) -> np.ndarray:
    """Return linear RGB (..., 3) in standard deviations: brightness, hue along, across `_LAMP`."""
    axes = log_axes(linear)
    hue = axes[..., 1:] @ np.array([_LAMP, [-_LAMP[1], _LAMP[0]]]).T
    return np.concatenate([axes[..., :1], hue], axis=-1) / np.array(_S.light)


def _strength(rows: pd.DataFrame) -> float:
    """Return how strong the usual colour of rows is, in standard deviations."""
    return float(np.linalg.norm(_scaled(_usual(rows))[1:]))


def _is_wood(rows: pd.DataFrame) -> bool:
    """Return whether the usual colour of rows is one of bare wood."""
    return bool(is_wood(rgb_to_lab(linear_to_srgb(np.minimum(_usual(rows), 1.0)))))


def _usual(rows: pd.DataFrame) -> np.ndarray:
    """Return the usual linear RGB (3,) of rows of ``colours.parquet``."""
    return usual_colour([_colours(c) for c in rows["colours"]], rows["weight"])


def _colours(cell: np.ndarray) -> np.ndarray:
    return np.asarray(cell, dtype=np.float64).reshape(-1, 3)
