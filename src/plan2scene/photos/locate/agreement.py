"""How well a mask agrees with what a camera in a room would see of the plan.

No picture is drawn: along one azimuth a room is a stack of floor, wall and ceiling, and a search
scores thousands of places a photo by a few look-ups for each direction (:mod:`.profile`).
"""

from __future__ import annotations

import numpy as np

from plan2scene.photos.locate.likelihood import BEHIND, ROOM, hole_class
from plan2scene.photos.locate.plan_view import Hole, RoomShape, Sight
from plan2scene.photos.locate.profile import Profile


def agreement(profile: Profile, shape: RoomShape, sight: Sight, heights: np.ndarray) -> np.ndarray:
    """Return the mean log probability (p, c) of a mask's pixels from p eyes at c heights, metres.

    `sight` has the directions of eye 0, then of eye 1, ...; each eye's are the profile's columns.
    A door is open or shut as a whole, whichever agrees better with what the eye sees of it.
    """
    columns = len(profile.azimuth)
    eyes = len(sight.reach) // columns
    index = np.tile(np.arange(columns), eyes)
    met = [np.flatnonzero(sight.hole == number) for number in range(len(shape.holes))]
    totals = []
    for height in heights.tolist():
        foot = profile.row(-height / sight.reach)
        head = profile.row((shape.height - height) / sight.reach)
        total = _bare(profile, index, foot, head).reshape(eyes, columns).sum(axis=1)
        for hole, at in zip(shape.holes, met, strict=True):
            if len(at):
                states = _through(profile, hole, sight.of(at), index[at], foot[at], height)
                sums = [np.bincount(at // columns, state, minlength=eyes) for state in states]
                total += np.max(sums, axis=0)
        totals.append(total)
    return np.stack(totals, axis=1)


def _bare(profile: Profile, index: np.ndarray, foot: np.ndarray, head: np.ndarray) -> np.ndarray:
    """Return the log probability (n,) of the labels in each direction of a room without holes."""
    total = profile.between(ROOM["floor"], index, np.zeros_like(foot), foot)
    total += profile.between(ROOM["wall"], index, foot, head)
    total += profile.between(ROOM["ceiling"], index, head, np.full_like(head, profile.rows))
    return np.asarray(total)


def _through(
    profile: Profile, hole: Hole, sight: Sight, index: np.ndarray, foot: np.ndarray, height: float
) -> list[np.ndarray]:
    """Return by how much (n,) a hole changes the log probability of directions that meet it.

    One array for each state that it may be in: shut, and open to the room behind.
    """
    bottom = np.maximum(profile.row((hole.bottom - height) / sight.reach), foot)
    top = np.maximum(profile.row((hole.top - height) / sight.reach), bottom)
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
    seen = [
        profile.between(hole_class(hole.kind, behind), index, low, high)
        for behind, (low, high) in zip(BEHIND, parts, strict=False)
    ]
    opened = np.where(known, sum(seen) - wall, shut)
    return [opened] if hole.kind == "passage" else [shut, opened]
