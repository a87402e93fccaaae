"""What floors, walls and ceilings are of: by looks, by which of the three they are, by the room."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import pandas as pd

    from plan2scene.house import House

#: How often surfaces of homes are of each substance, in the order of ``house.SUBSTANCES``: no
#: ceiling is carpet, however woolly the photo.
SUBSTANCES_OF = {
    "floor": (0.45, 0.03, 0.26, 0.26),
    "wall": (0.02, 0.92, 0.002, 0.058),
    "ceiling": (0.025, 0.965, 0.001, 0.009),
}
#: The same of floors in rooms of which one is usual, whatever the rest of the house has.
FLOORS_OF = {
    "Bathroom": (0.06, 0.02, 0.03, 0.89),
    "Outdoor": (0.2, 0.25, 0.01, 0.54),
    "Terrace": (0.2, 0.25, 0.01, 0.54),
    "Balcony": (0.2, 0.25, 0.01, 0.54),
}
#: The head is surer than it is right on real photos: its logits count this many times less.
TEMPERATURE = 3.0


def usual_shares(surface: str, types: Collection[str] = ()) -> np.ndarray:
    """Return how often a kind of surface is of each substance, (4,), in a room of some types."""
    rooms = [FLOORS_OF.get(name, SUBSTANCES_OF["floor"]) for name in types]
    if surface != "floor" or not rooms:
        return np.array(SUBSTANCES_OF[surface])
    return np.mean(rooms, axis=0)


def on_surfaces(probabilities: np.ndarray, surfaces: Sequence[str]) -> np.ndarray:
    """Return substances' probabilities (..., n, 4), knowing which kind of surface each of n is."""
    if not probabilities.size:
        return probabilities
    return weighed(probabilities, np.array([usual_shares(surface) for surface in surfaces]))


def weighed(probabilities: np.ndarray, usual: np.ndarray) -> np.ndarray:
    """Return substances' probabilities (..., 4) where `usual` (..., 4) is how often each is met.

    Bayes' rule: those of the texture model's head, softened, times the usual shares.
    """
    found = np.maximum(probabilities, 1e-12) ** (1.0 / TEMPERATURE) * usual
    return np.asarray(found / found.sum(axis=-1, keepdims=True), dtype=np.float32)


def jointed_floors(embeddings: pd.DataFrame, house: House) -> dict[str, tuple[float, float]]:
    """Return how probably each room's floor is of wood, and of tiles, by the rows of its crops."""
    found = {}
    floors = embeddings[embeddings["crop_id"].str.startswith("floor/")]
    for room, rows in floors.groupby("room_id"):
        usual = usual_shares("floor", house.room(str(room)).types)
        shares = weighed(np.stack(rows["substance_probabilities"].to_list()), usual).mean(axis=0)
        found[str(room)] = float(shares[0]), float(shares[3])
    return found
