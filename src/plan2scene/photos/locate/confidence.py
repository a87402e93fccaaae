"""How probable it is that a pose is right: a logistic of how clearly it beats the others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

#: Margins are logarithmic above this.
FLOOR = 0.004
#: Weights of `features`.
WEIGHTS = (6.0, 2.5, 0.5, 2.0, 0.5, 0.0)


@dataclass(frozen=True)
class Evidence:
    """What is known of a best pose."""

    #: Lead in score over the best pose of another heading or room, and at another position.
    heading: float
    elsewhere: float
    #: Mean log probability of a pixel's label.
    score: float
    #: Confidence of the camera's focal length.
    camera: float
    #: Whether the masks tell doors and windows.
    has_openings: bool


def features(evidence: Evidence) -> np.ndarray:
    """Return (6,): a constant, both margins, agreement, the camera's confidence, openings."""
    return np.array(
        [
            1.0,
            np.log10(max(evidence.heading, 0.0) + FLOOR),
            np.log10(max(evidence.elsewhere, 0.0) + FLOOR),
            evidence.score,
            evidence.camera,
            float(evidence.has_openings),
        ]
    )


def probability(evidence: Evidence) -> float:
    """Return the probability that heading and position are right."""
    logit = float(features(evidence) @ np.array(WEIGHTS))
    return float(1.0 / (1.0 + np.exp(-logit)))
