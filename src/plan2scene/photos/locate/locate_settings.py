"""Constants of the search for a photo's place in the plan."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Grid:
    """Positions in a room: about so many `points`, between these sides apart, metres."""

    points: int
    side_m: tuple[float, float]


@dataclass(frozen=True)
class LocateSettings:
    """Constants of the search for a photo's place in the plan.

    Source, where a field names no other: set by hand on two real flats (development) and the
    demo, which ``benchmarks/locate.py`` scores.
    """

    # The room in plan view.
    #: An opening lies on an edge of a room that runs its way: least cosine.
    parallel: float = 0.94
    #: ... and that is this near, metres.
    near_m: float = 0.35
    #: Length of a direction that leaves the house through no edge, metres.
    far_m: float = 30.0
    #: The edge by which a direction leaves the room behind an opening is farther than the opening
    #: by this, metres.
    entry_m: float = 0.02

    # The mask by direction.
    #: Columns of pixels that are sampled.
    sampled_columns: int = 200
    #: Sides of the bins, radians.
    azimuth_step: float = float(np.radians(1.5))
    elevation_step: float = float(np.radians(0.75))
    #: Elevations beyond this are left out, radians.
    max_elevation: float = float(np.radians(75.0))
    #: Least probability of a label: half a step of an 8-bit file.
    least_probability: float = 0.5 / 255
    #: Blur of the coarse and the fine search, radians: the error of plan and frame.
    coarse_blur: float = float(np.radians(3.0))
    fine_blur: float = float(np.radians(1.0))

    # What a mask says (other, floor, wall, ceiling, door, window) where the plan shows something.
    #: Probabilities where the plan shows the room's floor, wall, ceiling.
    room_rows: tuple[tuple[float, ...], ...] = (
        (0.22, 0.66, 0.07, 0.005, 0.03, 0.015),
        (0.22, 0.04, 0.60, 0.04, 0.06, 0.04),
        (0.08, 0.005, 0.08, 0.81, 0.015, 0.01),
    )
    #: The same of a shut door, a window, and what of a passage is no view of the room behind.
    hole_rows: dict[str, tuple[float, ...]] = field(
        default_factory=lambda: {
            "door": (0.14, 0.02, 0.14, 0.02, 0.64, 0.04),
            "window": (0.24, 0.02, 0.16, 0.03, 0.07, 0.48),
            "passage": (0.20, 0.06, 0.20, 0.05, 0.46, 0.03),
        }
    )
    #: Share of what is behind that shows through an open door, a window, a passage.
    seen_through: dict[str, float] = field(
        default_factory=lambda: {"door": 0.7, "window": 0.05, "passage": 0.85}
    )

    #: Bottom and top of windows that a plan does not draw, metres: usual sizes.
    undrawn_m: tuple[tuple[float, float], ...] = ((0.9, 2.1), (0.0, 2.1))

    # The grid of positions.
    #: Least distance of a camera from the walls on the grid and after refinement, metres.
    clearance_m: float = 0.15
    least_clearance_m: float = 0.05
    #: The grid in a photo's room, and that of rooms of which the photo's is to be found.
    grid: Grid = Grid(260, (0.2, 0.4))
    rough: Grid = Grid(70, (0.2, 0.8))
    #: Heights that are tried, metres.
    heights_m: tuple[float, ...] = (1.0, 1.2, 1.4, 1.6, 1.8)
    #: Mean and standard deviation of a camera's height, metres.
    height_m: float = 1.45
    height_spread_m: float = 0.25
    #: Weight of that prior against the mean log probability of a pixel.
    prior_weight: float = 0.02

    # Refinement.
    #: Peaks of a heading that are refined.
    peaks: int = 3
    #: Least distance between them, metres.
    apart_m: float = 0.6
    #: First and last step, metres.
    first_step_m: float = 0.16
    last_step_m: float = 0.02

    # The height that the photos of a house share.
    #: Photos whose headings differ in score by this give the height of the others.
    clear_margin: float = 0.04
    #: Least number of such photos.
    min_clear: int = 3
    #: Least standard deviation of the shared height, metres.
    min_spread_m: float = 0.06

    # Probability that a place is right.
    #: Another position is at least so far away, metres.
    elsewhere_m: float = 1.0
    #: Leads are logarithmic above this (score).
    lead_floor: float = 0.004
    #: Weights of a constant and of both leads. Source: a fit on 329 synthetic photos with true and
    #: predicted masks (right: the heading, within 1 m), calibrated on two real flats (development).
    weights: tuple[float, float, float] = (5.0, 2.4, 0.5)
    #: Subtracted from the logit by what tells openings, by which alike rooms differ: labels, a
    #: network's probabilities (it misses half of the doors), nothing.
    less_sure: dict[str, float] = field(
        default_factory=lambda: {"labels": 0.0, "probabilities": 1.0, "nothing": 1.2}
    )
    #: Subtracted from the logit for each e-fold of the number of possible rooms.
    more_rooms: float = 0.2

    # Whose surface a pixel shows.
    #: Directions in a turn.
    directions: int = 2880
    #: How far plan and pose may be off, metres, and share of the distance.
    off_m: float = 0.15
    off_share: float = 0.12
    #: Wall pixels nearer to a corner than this are left out, metres.
    corner_m: float = 0.06
    #: A pose that gives less than this share of the surfaces' pixels an owner contradicts the mask.
    min_explained: float = 0.55
    #: A pose that gives its own room less than this share of what it explains is not believed.
    #: Source: of four such poses of synthetic and real homes (development) none was right.
    min_own: float = 0.1


LOCATE = LocateSettings()
