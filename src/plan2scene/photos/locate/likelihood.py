"""How probable each label of a mask is where the plan shows something.

Rows are what the plan shows, columns what a mask says. A hole of unknown ``behind`` is shut;
through others shows what lies behind them, by a share.
"""

from __future__ import annotations

import numpy as np

from plan2scene.photos.labels.palette import DOOR, LABELS_AND_OPENINGS, OTHER, WINDOW

#: A door or a window, not told which.
OPENING = len(LABELS_AND_OPENINGS)
N_LABELS = OPENING + 1
#: Classes of what the plan shows: the room itself, then through a hole (``kind``, ``behind``).
ROOM = {"floor": 0, "wall": 1, "ceiling": 2}
BEHIND = ("floor", "wall", "ceiling", "unknown")
HOLES = ("door", "window", "passage")
N_CLASSES = 3 + len(HOLES) * len(BEHIND)
#: Openings that masks may tell. A network's probabilities take doors for things.
TOLD = {
    "nothing": frozenset[int](),
    "windows": frozenset({WINDOW}),
    "all": frozenset({DOOR, WINDOW}),
}

_ROOM_ROWS = (
    (0.22, 0.66, 0.07, 0.005, 0.03, 0.015),
    (0.22, 0.04, 0.60, 0.04, 0.06, 0.04),
    (0.08, 0.005, 0.08, 0.81, 0.015, 0.01),
)
#: A shut door, a window, and what of a passage is no view of the room behind.
_HOLE_ROWS = {
    "door": (0.14, 0.02, 0.14, 0.02, 0.64, 0.04),
    "window": (0.24, 0.02, 0.16, 0.03, 0.07, 0.48),
    "passage": (0.20, 0.06, 0.20, 0.05, 0.46, 0.03),
}
#: Share of what is behind that shows through: an open door, a window, a passage.
_SEEN_THROUGH = {"door": 0.7, "window": 0.05, "passage": 0.85}


def hole_class(kind: str, behind: str) -> int:
    """Return the class of what is seen through a hole."""
    return 3 + HOLES.index(kind) * len(BEHIND) + BEHIND.index(behind)


def log_table(told: str) -> np.ndarray:
    """Return (N_CLASSES, N_LABELS) float64 log probabilities of a label given a class.

    `told`, of `TOLD`, says which openings masks tell; others are other.
    """
    table = np.zeros((N_CLASSES, N_LABELS))
    table[:3, :OPENING] = _ROOM_ROWS
    for kind in HOLES:
        shut, share = np.array(_HOLE_ROWS[kind]), _SEEN_THROUGH[kind]
        for behind in BEHIND:
            seen = shut if behind == "unknown" else table[ROOM[behind], :OPENING]
            table[hole_class(kind, behind), :OPENING] = (1 - share) * shut + share * seen
    hidden = [OTHER, *({DOOR, WINDOW} - TOLD[told])]
    table[:, hidden] = table[:, hidden].sum(axis=1, keepdims=True)
    table[:, OPENING] = table[:, DOOR] + table[:, WINDOW]
    return np.asarray(np.log(np.maximum(table, 1e-4)))
