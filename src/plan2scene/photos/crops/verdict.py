"""Why a window is no good crop, and how bad that is."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum

#: Score of a window that may show something else than its surface.
GRAVE = 1.0
#: Reasons of a crop that is kept for want of a better one begin with this in candidates.parquet.
_LAST_RESORT = "last resort: "


class Reason(StrEnum):
    """What is wrong with a window, from the worst to the mildest."""

    BORDER = "border"
    CLUTTER = "clutter"
    UNLIKE = "unlike the rest"
    HIGHLIGHT = "highlight"
    SHADOW = "shadow edge"
    # From here on the window shows its surface, but poorly.
    BLURRED = "not sharp"
    OBLIQUE = "oblique"
    UNKNOWN_DISTANCE = "unknown distance"


_GRAVE_REASONS = tuple(Reason)[:5]


@dataclass(frozen=True)
class Verdict:
    """What is wrong with a window, if anything."""

    #: From the worst to the mildest; empty for a good one.
    reasons: tuple[Reason, ...] = ()
    #: Orders the refused: where a surface has nothing good, those of least score are kept. From
    #: `GRAVE` on a window may not show the surface.
    score: float = 0.0

    @classmethod
    def of(cls, reasons: Iterable[Reason], sharpness: float) -> Verdict:
        """Return the verdict on a window for these reasons, in any order.

        Any grave reason weighs more than all mild ones; of equals the sharper crop (`sharpness`
        in photo pixels per crop pixel) is better.
        """
        given = set(reasons)
        if not given:
            return cls()
        grave = len(_GRAVE_REASONS)
        score = sum(
            GRAVE * 2 ** (grave - 1 - rank) if rank < grave else 0.25
            for rank, reason in enumerate(Reason)
            if reason in given
        )
        ordered = tuple(reason for reason in Reason if reason in given)
        return cls(ordered, score + 0.2 * GRAVE / (1.0 + sharpness))

    @property
    def good(self) -> bool:
        """Whether nothing is wrong."""
        return not self.reasons

    @property
    def grave(self) -> bool:
        """Whether the window may show something else than its surface."""
        return self.score >= GRAVE


def reason_text(verdict: Verdict, *, kept: bool) -> str:
    """Return the cell ``reason`` of candidates.parquet: empty for a good window.

    `kept` tells a crop that is kept for want of a better one.
    """
    text = ", ".join(verdict.reasons)
    return _LAST_RESORT + text if kept and text else text


def reasons_of_text(text: str) -> tuple[str, ...]:
    """Return the reasons of a cell ``reason`` of candidates.parquet."""
    return tuple(part for part in text.removeprefix(_LAST_RESORT).split(", ") if part)
