"""Light of training homes: rooms, photos, and what is seen through a door."""

from dataclasses import replace

import numpy as np
import pytest

from plan2scene.colour import log_axes, srgb_to_linear
from plan2scene.propagation.graph import HouseGraph
from plan2scene_workshop.propagation.light import CORRECTED, PHOTOS, lit


def grey(rooms: int = 40) -> HouseGraph:
    """Return rooms in a row, all surfaces of one grey and random codes."""
    values = np.random.default_rng(1).normal(size=(rooms, 3, 11)).astype(np.float32)
    values[..., -3:] = 0.5
    chain = np.array([[i, i + 1] for i in range(rooms - 1)]).T
    ids = tuple(f"r{i}" for i in range(rooms))
    types = np.zeros((rooms, 12), np.float32)
    edges = np.concatenate([chain, chain[::-1]], axis=1)
    return HouseGraph(ids, types, edges, values, np.ones((rooms, 3), dtype=bool))


def test_surfaces_of_a_room_share_its_light():
    _, truth = lit(grey(), np.random.default_rng(0), CORRECTED)
    colours = truth[..., -3:]
    assert np.abs(colours - colours[:, :1]).max() < 1e-6
    assert colours[:, 0].std(axis=0).min() > 0.02


def test_rooms_differ_along_the_line_from_lamps_to_daylight():
    light = replace(PHOTOS, room_warmth=(0.3, 0.3), room_tint=0.01, surface=(0.0, 0.0))
    _, truth = lit(grey(), np.random.default_rng(0), light)
    axes = log_axes(srgb_to_linear(truth[:, 0, -3:]))
    assert axes[:, 1].std() == pytest.approx(0.3, rel=0.3)
    assert np.corrcoef(axes[:, 1], axes[:, 2])[0, 1] < -0.9


def test_photos_tell_the_truth_but_for_their_part_and_doors():
    graph, rng = grey(), np.random.default_rng(0)
    told, truth = lit(graph, rng, replace(PHOTOS, photo=(0.0, 0.0), code=0.0, next_room=0.0))
    np.testing.assert_array_equal(told, truth)
    np.testing.assert_array_equal(truth[..., :8], graph.embeddings[..., :8])
    told, truth = lit(graph, rng, replace(PHOTOS, photo=(0.0, 0.0), code=0.0, next_room=0.2))
    wrong = np.abs(told - truth).max(axis=2) > 0
    assert 0.1 < wrong.mean() < 0.3
    # A code behind a door lies between the room's own and a neighbour's.
    room, kind = np.argwhere(wrong)[0]
    behind = graph.edges[1, graph.edges[0] == room]
    own, seen = graph.embeddings[room, kind, :8], told[room, kind, :8]
    shares = [(seen - own) / (graph.embeddings[n, kind, :8] - own) for n in behind]
    assert any(np.ptp(share) < 1e-3 and 0.3 <= share[0] <= 1.0 for share in shares)
    assert lit(graph, rng, PHOTOS)[0].dtype == np.float32
