"""How probable it is that a pose is right: a logistic of how clearly it beats the others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

#: Leads are logarithmic above this.
FLOOR = 0.004
#: Weights of a constant and both leads: fitted on 329 synthetic photos with true and predicted
#: masks (right: the heading, within 1 m), calibrated on two real flats (development).
WEIGHTS = (5.0, 2.4, 0.5)
#: What masks take off that tell fewer openings (`likelihood.TOLD`): those make rooms differ that
#: look alike; chosen on the same flats.
LESS = {"all": 0.0, "windows": 1.0, "nothing": 1.2}
#: What each e times as many rooms take off where several are possible: more of them look like the
#: right one; chosen on the same flats.
ROOMS = 0.2


@dataclass(frozen=True)
class Evidence:
    """What is known of a best pose."""

    #: Lead in score over the best pose of another heading or room, and at another position.
    heading: float
    elsewhere: float
    #: Which openings the masks tell, of `likelihood.TOLD`.
    told: str
    #: How many rooms it may have been taken in.
    rooms: int = 1


def probability(evidence: Evidence) -> float:
    """Return the probability that heading and position are right."""
    leads = np.maximum([evidence.heading, evidence.elsewhere], 0.0)
    logit = WEIGHTS[0] + float(np.log10(leads + FLOOR) @ np.array(WEIGHTS[1:]))
    logit -= LESS[evidence.told] + ROOMS * float(np.log(evidence.rooms))
    return float(1.0 / (1.0 + np.exp(-logit)))
