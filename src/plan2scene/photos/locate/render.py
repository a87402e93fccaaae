"""How well a mask agrees with what a camera in a room would see of the plan."""

from __future__ import annotations

import numpy as np

from plan2scene.photos.locate.likelihood import BEHIND, ROOM, hole_class
from plan2scene.photos.locate.plan_view import Hole, RoomShape, Sight
from plan2scene.photos.locate.profile import Profile


def agreement(profile: Profile, shape: RoomShape, sight: Sight, heights: np.ndarray) -> np.ndarray:
    """Return the mean log probability (p, c) of a mask's pixels from p eyes at c heights, metres.

    `sight` has the directions of eye 0, then of eye 1, ...; each eye's are the profile's columns.
    """
    columns = len(profile.azimuth)
    index = np.tile(np.arange(columns), len(sight.reach) // columns)
    totals = [_stack(profile, shape, sight, index, height) for height in heights.tolist()]
    return np.stack([total.reshape(-1, columns).sum(axis=1) for total in totals], axis=1)


def _stack(
    profile: Profile, shape: RoomShape, sight: Sight, index: np.ndarray, height: float
) -> np.ndarray:
    """Return the log probability (n,) of the labels in each direction, for a camera at a height."""
    foot = profile.row(-height / sight.reach)
    head = profile.row((shape.height - height) / sight.reach)
    total = profile.between(ROOM["floor"], index, np.zeros_like(foot), foot)
    total += profile.between(ROOM["wall"], index, foot, head)
    total += profile.between(ROOM["ceiling"], index, head, np.full_like(head, profile.rows))
    for number, hole in enumerate(shape.holes):
        met = np.flatnonzero(sight.hole == number)
        if len(met):
            total[met] += _through(profile, hole, sight, met, index[met], foot[met], height)
    return np.asarray(total)


def _through(
    profile: Profile,
    hole: Hole,
    sight: Sight,
    met: np.ndarray,
    index: np.ndarray,
    foot: np.ndarray,
    height: float,
) -> np.ndarray:
    """Return by how much (n,) a hole changes the log probability of the directions `met`."""
    reach, beyond, above = sight.reach[met], sight.beyond[met], sight.beyond_height[met]
    bottom = np.maximum(profile.row((hole.bottom - height) / reach), foot)
    top = np.maximum(profile.row((hole.top - height) / reach), bottom)
    changed = -profile.between(ROOM["wall"], index, bottom, top)
    known = np.isfinite(beyond)
    beyond, above = np.where(known, beyond, reach), np.where(known, above, height)
    far_foot = np.clip(profile.row(-height / beyond), bottom, top)
    far_head = np.clip(profile.row((above - height) / beyond), far_foot, top)
    parts = ((bottom, far_foot), (far_foot, far_head), (far_head, top), (bottom, top))
    seen = {
        behind: profile.between(hole_class(hole.kind, behind), index, low, high)
        for behind, (low, high) in zip(BEHIND, parts, strict=True)
    }
    open_ = seen["floor"] + seen["wall"] + seen["ceiling"]
    return np.asarray(changed + np.where(known, open_, seen["unknown"]))
