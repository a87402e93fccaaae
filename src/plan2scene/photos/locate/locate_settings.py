"""Constants of the search for a photo's place in the plan."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Grid:
    """A grid of about `points` positions in a room; its spacing lies within `side_m`, metres."""

    points: int
    side_m: tuple[float, float]


@dataclass(frozen=True)
class LocateSettings:
    """Constants of the search for a photo's place in the plan.

    Source, where a field names no other: set by hand on two real flats (development) and the
    demo, which ``benchmarks/locate.py`` scores.
    """

    # The room in plan view.
    #: An opening lies on a parallel edge of its room: least cosine of the angle between the two.
    parallel: float = 0.94
    #: Largest distance of the opening from that edge, beyond the wall's depth, metres.
    near_m: float = 0.35
    #: Largest distance that a ray reaches, also where it meets no edge, metres.
    far_m: float = 30.0
    #: A ray through an opening leaves the room behind it at least this far beyond the opening,
    #: metres.
    entry_m: float = 0.02

    # The mask, binned by direction.
    #: Number of columns of pixels that are sampled (rows with the same step).
    sampled_columns: int = 200
    #: Sizes of the bins, radians.
    azimuth_step: float = float(np.radians(1.5))
    elevation_step: float = float(np.radians(0.75))
    #: Pixels farther than this above or below the horizon are left out, radians.
    max_elevation: float = float(np.radians(75.0))
    #: Lower limit of a label's probability: half a step of an 8-bit file.
    least_probability: float = 0.5 / 255
    #: Sigma of the blur in the coarse and the fine search, radians: the error of plan and frame.
    coarse_blur: float = float(np.radians(3.0))
    fine_blur: float = float(np.radians(1.0))

    # Probabilities of a mask's labels (other, floor, wall, ceiling, door, window).
    #: A row each for pixels where the plan shows the room's floor, wall and ceiling.
    room_rows: tuple[tuple[float, ...], ...] = (
        (0.22, 0.66, 0.07, 0.005, 0.03, 0.015),
        (0.22, 0.04, 0.60, 0.04, 0.06, 0.04),
        (0.08, 0.005, 0.08, 0.81, 0.015, 0.01),
    )
    #: A row each for a shut door, a window, and the part of a passage that hides the room behind.
    hole_rows: dict[str, tuple[float, ...]] = field(
        default_factory=lambda: {
            "door": (0.14, 0.02, 0.14, 0.02, 0.64, 0.04),
            "window": (0.24, 0.02, 0.16, 0.03, 0.07, 0.48),
            "passage": (0.20, 0.06, 0.20, 0.05, 0.46, 0.03),
        }
    )
    #: Weight (0..1) of what lies behind, seen through an open door, a window or a passage.
    seen_through: dict[str, float] = field(
        default_factory=lambda: {"door": 0.7, "window": 0.05, "passage": 0.85}
    )

    #: Bottom and top of windows that a plan does not draw, metres above the floor: usual sizes.
    undrawn_m: tuple[tuple[float, float], ...] = ((0.9, 2.1), (0.0, 2.1))

    # The grid of positions.
    #: Least distance of a camera from the walls: on the grid, and after refinement, metres.
    clearance_m: float = 0.15
    least_clearance_m: float = 0.05
    #: Grid for the final search of a pose, and for the rough search that compares rooms.
    grid: Grid = Grid(260, (0.2, 0.4))
    rough: Grid = Grid(70, (0.2, 0.8))
    #: Camera heights that are tried, metres.
    heights_m: tuple[float, ...] = (1.0, 1.2, 1.4, 1.6, 1.8)
    #: Prior of a camera's height: mean and standard deviation, metres.
    height_m: float = 1.45
    height_spread_m: float = 0.25
    #: Weight of that log prior; the mean log probability of a pixel has weight 1.
    prior_weight: float = 0.02

    # Refinement.
    #: Number of peaks of the grid that are refined, for each room and heading.
    peaks: int = 3
    #: Least distance between these peaks, metres.
    apart_m: float = 0.6
    #: First step of the pattern search, metres; it ends when the step is at most the last one.
    first_step_m: float = 0.16
    last_step_m: float = 0.02

    # The camera height that the photos of a house share.
    #: Spots whose best heading leads by at least this score determine the height for all spots.
    clear_margin: float = 0.04
    #: Least number of such spots.
    min_clear: int = 3
    #: Least standard deviation of the shared height, metres.
    min_spread_m: float = 0.06

    # Probability that a pose is right.
    #: A pose farther than this from the best one counts as another position, metres.
    elsewhere_m: float = 1.0
    #: Added to a lead in score before its logarithm is taken.
    lead_floor: float = 0.004
    #: Weights of the logit: a constant, then log10 of the leads over other headings and positions.
    #: Source: a fit on 329 synthetic photos with true and predicted masks (right: correct heading,
    #: within 1 m), calibrated on two real flats (development).
    weights: tuple[float, float, float] = (5.0, 2.4, 0.5)
    #: Subtracted from the logit, by how masks mark doors and windows (which tell similar rooms
    #: apart): labels, a network's probabilities (it misses half of the doors), or nothing.
    less_sure: dict[str, float] = field(
        default_factory=lambda: {"labels": 0.0, "probabilities": 1.0, "nothing": 1.2}
    )
    #: Subtracted from the logit for each e-fold of the number of possible rooms.
    more_rooms: float = 0.2

    # The room whose surface a pixel shows.
    #: Number of azimuths in a full turn for which rays are cast.
    directions: int = 2880
    #: Tolerance for errors of plan and pose: metres, and share of the distance.
    off_m: float = 0.15
    off_share: float = 0.12
    #: Wall pixels nearer to a corner than this are left out, metres.
    corner_m: float = 0.06
    #: A pose contradicts the mask if less than this share of the floor, wall and ceiling pixels
    #: can be assigned to a room.
    min_explained: float = 0.55
    #: A pose is rejected if its own room has less than this share of the assigned pixels.
    #: Source: none of four such poses in synthetic and real homes (development) was right.
    min_own: float = 0.1


LOCATE = LocateSettings()
