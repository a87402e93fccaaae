"""How a house knows what a surface looks like, for people: seen, like another room, guessed."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from typing import Any

from plan2scene.house import SURFACES, SurfaceKey

#: Mean CIEDE2000 to the true material by kind of surface, seen and not, and of a seen wall or
#: ceiling of a colour: 43 synthetic homes with 60 % of their photos hidden (development).
SEEN, UNSEEN, COLOURED = (8.3, 6.2, 2.6), (16.1, 11.9, 2.6), 12.9
DOUBTFUL = 10.0  #: Expected error from which on people are told


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
    named = re.findall(r"\b(?:like|of) ([^\s,]+)", str(entry.get("source", "")))
    like = next((name for name in named if name in rooms), None)
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
