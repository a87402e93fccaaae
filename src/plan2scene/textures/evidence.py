"""How a house knows what a surface looks like, for people: seen, like another room, guessed."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from typing import Any

from plan2scene.house import SurfaceKey


def evidence_of(
    key: SurfaceKey,
    entry: Mapping[str, Any],
    photos: Sequence[str],
    rooms: Collection[str],
    *,
    white: bool,
) -> dict[str, Any]:
    """Return ``{photos, like, words}`` of a surface; ``like`` is the room that it is guessed from.

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
    return {"photos": list(photos), "like": room, "words": words}
