"""Likelihood of a photo's mask, given a pose in the plan.

At one azimuth a room is a stack from below: floor, wall (with what an opening shows), ceiling.
A table gives the probability of each label of a mask for each class of the plan. A mask is binned
by azimuth and elevation. The log probabilities are summed up over elevation for each class, so that
the likelihood of any stack takes a few look-ups. No image is rendered, since a search scores
thousands of positions for each photo.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import cv2
import numpy as np

from plan2scene.camera import Camera
from plan2scene.photos.labels.palette import DOOR, LABELS_AND_OPENINGS, OTHER, WINDOW
from plan2scene.photos.locate.locate_settings import LOCATE
from plan2scene.photos.locate.plan_view import UNDRAWN, Hole, RoomShape, Sight

#: Label of an opening that may be a door or a window.
OPENING = len(LABELS_AND_OPENINGS)
N_LABELS = OPENING + 1
#: Classes of what the plan shows: the room itself, then what is `BEHIND` a hole of each kind.
ROOM = {"floor": 0, "wall": 1, "ceiling": 2}
HOLES = ("door", "window", "passage")
BEHIND = ("floor", "wall", "ceiling", "unknown", *HOLES)
N_CLASSES = 3 + len(HOLES) * len(BEHIND)


def hole_class(kind: str, behind: str) -> int:
    """Return the class of what is seen through a hole of a `kind`: `behind` is one of `BEHIND`."""
    return 3 + HOLES.index(kind) * len(BEHIND) + BEHIND.index(behind)


def log_table(*, openings: bool) -> np.ndarray:
    """Return (N_CLASSES, N_LABELS) float64 log probabilities of a label given a class.

    If masks label no `openings`, the labels other, door and window share one probability.
    """
    table = np.zeros((N_CLASSES, N_LABELS))
    table[:3, :OPENING] = LOCATE.room_rows
    for kind in HOLES:
        shut, share = np.array(LOCATE.hole_rows[kind]), LOCATE.seen_through[kind]
        for behind in BEHIND:
            behind_row = np.array(LOCATE.hole_rows.get(behind, shut))
            if behind in ROOM:
                behind_row = table[ROOM[behind], :OPENING]
            table[hole_class(kind, behind), :OPENING] = (1 - share) * shut + share * behind_row
    if not openings:
        hidden = [OTHER, DOOR, WINDOW]
        table[:, hidden] = table[:, hidden].sum(axis=1, keepdims=True)
    table[:, OPENING] = table[:, DOOR] + table[:, WINDOW]
    return np.asarray(np.log(np.maximum(table, 1e-4)))


@dataclass(frozen=True)
class Profile:
    """A photo's labels, binned by direction in its Manhattan frame; float64, radians."""

    azimuth: np.ndarray  #: (a,), middle of each column, ``(x, z) = (sin a, cos a)``
    lowest: float  #: elevation of the lower border of the first row
    #: (classes, a, rows + 1), log probability of the labels given each class, summed over all rows
    #: below the lower border of each row; the last entry is the sum over all rows. Each pixel has
    #: the weight 1 / number of pixels.
    sums: np.ndarray

    @property
    def rows(self) -> int:
        """Number of rows."""
        return int(self.sums.shape[2]) - 1

    def row(self, slope: np.ndarray) -> np.ndarray:
        """Return the fractional row at elevations with these tangents."""
        rows = (np.arctan(slope) - self.lowest) / LOCATE.elevation_step
        return np.asarray(np.clip(rows, 0.0, self.rows))

    def between(
        self, kind: int, column: np.ndarray, low: np.ndarray, high: np.ndarray
    ) -> np.ndarray:
        """Return the log probability (n,) of columns' labels between two rows, given a class."""
        return self._below(kind, column, high) - self._below(kind, column, low)

    def _below(self, kind: int, column: np.ndarray, row: np.ndarray) -> np.ndarray:
        whole = np.minimum(row.astype(np.int64), self.rows - 1)
        sums = self.sums[kind]
        start = sums[column, whole]
        return np.asarray(start + (row - whole) * (sums[column, whole + 1] - start))


def label_counts(
    labels: np.ndarray, camera: Camera, probabilities: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray, float]:
    """Return the share of each label by direction (labels, a, rows), azimuths, lowest elevation.

    `labels` (h, w) uint8; pixels with any other value are ignored. With `probabilities`
    (l, h', w') of the same view, each pixel counts for every label by the label's probability.
    """
    step = max(1.0, camera.width / LOCATE.sampled_columns)
    columns = np.arange(step / 2, camera.width, step)
    rows = np.arange(step / 2, camera.height, step)
    pixels = np.stack(np.meshgrid(columns, rows), axis=-1).reshape(-1, 2)
    values = labels[pixels[:, 1].astype(int), pixels[:, 0].astype(int)]
    rays = camera.rays(pixels - 0.5)
    azimuth = np.arctan2(rays[:, 0], rays[:, 2])
    elevation = np.arcsin(np.clip(rays[:, 1], -1.0, 1.0))
    kept = (np.abs(elevation) < LOCATE.max_elevation) & (values < N_LABELS)
    if not kept.any():
        return np.zeros((N_LABELS, 1, 1)), np.zeros(1), 0.0
    first = np.floor(azimuth[kept].min() / LOCATE.azimuth_step)
    lowest = np.floor(elevation[kept].min() / LOCATE.elevation_step)
    a = (azimuth[kept] / LOCATE.azimuth_step - first).astype(int)
    e = (elevation[kept] / LOCATE.elevation_step - lowest).astype(int)
    shape = (N_LABELS, int(a.max()) + 1, int(e.max()) + 1)
    counts = np.zeros(shape)
    if probabilities is None:
        np.add.at(counts, (values[kept].astype(int), a, e), 1.0)
    else:
        row, column = (
            np.minimum(at * new / old, new - 1).astype(int)
            for at, new, old in zip(
                pixels[kept].T[::-1], probabilities.shape[1:], labels.shape, strict=True
            )
        )
        likely = np.maximum(probabilities[:, row, column], LOCATE.least_probability)
        likely /= likely.sum(axis=0)
        for label, weights in enumerate(likely):
            np.add.at(counts[label], (a, e), weights)
    counts /= kept.sum()
    middles = (first + 0.5 + np.arange(shape[1])) * LOCATE.azimuth_step
    return counts, middles, float(lowest * LOCATE.elevation_step)


def make_profile(
    labels: np.ndarray,
    camera: Camera,
    table: np.ndarray,
    blur: float,
    probabilities: np.ndarray | None,
) -> Profile:
    """Return the profile of a mask; `table` (classes, labels) log probabilities.

    `blur` is the standard deviation of directions, radians; `probabilities` are those of
    `label_counts`.
    """
    counts, azimuth, lowest = label_counts(labels, camera, probabilities)
    up, across = blur / LOCATE.elevation_step, blur / LOCATE.azimuth_step
    log = [
        cv2.GaussianBlur(part, (0, 0), sigmaX=up, sigmaY=across, borderType=cv2.BORDER_REPLICATE)
        for part in np.tensordot(table, counts, axes=(1, 0))
    ]
    sums = np.pad(np.cumsum(log, axis=2), ((0, 0), (0, 0), (1, 0)))
    return Profile(azimuth, lowest, sums)


def agreement(
    profile: Profile,
    shapes: Mapping[str, RoomShape],
    room_id: str,
    sight: Sight,
    heights: np.ndarray,
) -> np.ndarray:
    """Return the mean log probability (p, c) of a mask's pixels from p eyes at c heights, metres.

    `sight` has the directions of eye 0, then of eye 1, and so on, one for each column of the
    profile. A door is open or shut as a whole: the state that agrees better counts.
    """
    shape, columns = shapes[room_id], len(profile.azimuth)
    eyes = len(sight.reach) // columns
    index = np.tile(np.arange(columns), eyes)
    met = [np.flatnonzero(sight.hole == number) for number in range(len(shape.holes))]
    totals = []
    for height in heights.tolist():
        foot = profile.row(-height / sight.reach)
        head = profile.row((shape.height - height) / sight.reach)
        bare = profile.between(ROOM["floor"], index, np.zeros_like(foot), foot)
        bare += profile.between(ROOM["wall"], index, foot, head)
        bare += profile.between(ROOM["ceiling"], index, head, np.full_like(head, profile.rows))
        total = bare.reshape(eyes, columns).sum(axis=1)
        for hole, at in zip(shape.holes, met, strict=True):
            if len(at):
                states = _through(profile, shapes, hole, sight.of(at), index[at], foot[at], height)
                sums = [np.bincount(at // columns, state, minlength=eyes) for state in states]
                total += np.max(sums, axis=0)
        totals.append(total)
    return np.stack(totals, axis=1)


def _undrawn_window(
    profile: Profile, sight: Sight, index: np.ndarray, foot: np.ndarray, height: float
) -> np.ndarray:
    """Return the gain in log probability (n,) of the best of a tall, a usual and no window."""
    gains = [np.zeros(len(index))]
    for ends in LOCATE.undrawn_m:
        low, high = (np.maximum(profile.row((up - height) / sight.reach), foot) for up in ends)
        window, wall = (
            profile.between(kind, index, low, high)
            for kind in (hole_class("window", "unknown"), ROOM["wall"])
        )
        gains.append(window - wall)
    return np.asarray(np.max(gains, axis=0))


def _through(
    profile: Profile,
    shapes: Mapping[str, RoomShape],
    hole: Hole,
    sight: Sight,
    index: np.ndarray,
    foot: np.ndarray,
    height: float,
) -> list[np.ndarray]:
    """Return the change (n,) that a hole makes to the log probability of directions that meet it.

    There is one array for each state that the hole may be in: shut, or open to the room behind,
    including that room's own openings.
    """
    bottom = np.maximum(profile.row((hole.bottom - height) / sight.reach), foot)
    top = np.maximum(profile.row((hole.top - height) / sight.reach), bottom)
    if hole.kind == UNDRAWN:
        return [_undrawn_window(profile, sight, index, foot, height)]
    wall = profile.between(ROOM["wall"], index, bottom, top)
    shut = profile.between(hole_class(hole.kind, "unknown"), index, bottom, top) - wall
    known = np.isfinite(sight.beyond)
    if not known.any():
        return [shut]
    beyond = np.where(known, sight.beyond, sight.reach)
    above = np.where(known, sight.beyond_height, height)
    far_foot = np.clip(profile.row(-height / beyond), bottom, top)
    far_head = np.clip(profile.row((above - height) / beyond), far_foot, top)
    parts = ((bottom, far_foot), (far_foot, far_head), (far_head, top))
    part_logs = [
        profile.between(hole_class(hole.kind, behind), index, low, high)
        for behind, (low, high) in zip(BEHIND, parts, strict=False)
    ]
    total = np.sum(part_logs, axis=0)
    holes = shapes[hole.room_behind].holes if hole.room_behind else ()
    for number, other in enumerate(holes):
        at = np.flatnonzero(sight.beyond_hole == number)
        if not len(at):
            continue
        undrawn = other.kind == UNDRAWN
        ends = LOCATE.undrawn_m[0] if undrawn else (other.bottom, other.top)
        low, high = (
            np.clip(profile.row((up - height) / beyond[at]), far_foot[at], far_head[at])
            for up in ends
        )
        opening_log, wall_log = (
            profile.between(hole_class(hole.kind, kind), index[at], low, high)
            for kind in ("window" if undrawn else other.kind, "wall")
        )
        # A door leaf often looks like a wall, and the door may be open: it counts only as a gain.
        sure = other.kind not in ("door", UNDRAWN)
        total[at] += opening_log - wall_log if sure else np.maximum(opening_log - wall_log, 0.0)
    opened = np.where(known, total - wall, shut)
    return [opened] if hole.kind == "passage" else [shut, opened]
