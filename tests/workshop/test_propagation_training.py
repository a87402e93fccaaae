from dataclasses import replace

import numpy as np
import pytest
from small_models import write_texture_models

from plan2scene.house import SURFACES
from plan2scene.propagation.graph import HouseGraph
from plan2scene.propagation.graph_networks import PointerNetwork, load_propagation
from plan2scene.propagation.type_means import TypeMeans
from plan2scene_workshop.propagation import measure, training
from plan2scene_workshop.propagation.light import CORRECTED
from plan2scene_workshop.propagation.run import train_propagation
from plan2scene_workshop.propagation.settings import PropagationSettings
from plan2scene_workshop.propagation.training import train_network


def house_of_one_colour(rng, rooms=4):
    """Return a chain of rooms that all share one embedding: what a graph can tell."""
    types = np.eye(12, dtype=np.float32)[rng.integers(12, size=rooms)]
    chain = [(i, i + 1) for i in range(rooms - 1)]
    edges = np.array(sorted([*chain, *((b, a) for a, b in chain)])).T
    value = np.concatenate([rng.normal(size=8), rng.uniform(0.1, 0.9, 3)]).astype(np.float32)
    embeddings = np.broadcast_to(value, (rooms, 3, 11)).copy()
    ids = tuple(f"r{i}" for i in range(rooms))
    return HouseGraph(ids, types, edges, embeddings, np.ones((rooms, 3), dtype=bool))


def test_training_learns_what_neighbours_tell(monkeypatch):
    still = replace(CORRECTED, room_brightness=(0.0, 0.0), room_tint=0.0)
    monkeypatch.setattr(training, "CORRECTED", still)
    rng = np.random.default_rng(2)
    graphs = [house_of_one_colour(rng) for _ in range(120)]
    settings = PropagationSettings(network="pointer", steps=200, batch=16, learning_rate=3e-3)
    settings = replace(settings, photo_light_share=0.0, room_drop_share=0.0)
    trained = train_network(graphs[:100], graphs[100:], settings, seed=0)
    homes = [(graph, graph.embeddings) for graph in graphs[100:] * 3]
    values = np.concatenate([graph.embeddings for graph in graphs])
    means = TypeMeans(np.tile(values.mean(axis=0), (12, 1, 1)), np.zeros((12, 3, 8)))
    errors = measure.hidden_errors(measure.predictors({"own": trained.network}, means), homes, 0)
    l1 = {name: e.absolute.mean() for name, e in errors.items()}
    # Where something is visible these two are exact in such houses.
    assert l1["house_mean"] == pytest.approx(l1["nearest_room"])
    assert l1["house_mean"] < 0.5 * l1[measure.YARDSTICK]
    assert l1["own"] < 0.6 * l1[measure.YARDSTICK]
    assert "| own |" in measure.error_table(errors)
    sure = errors["own"].confidence > 0.8  # of what it copies, and right about it
    assert sure.any()
    assert errors["own"].absolute[sure].mean() < 0.2 * l1[measure.YARDSTICK]
    assert "0.8-1.0" in measure.confidence_table(errors["own"])


def test_a_run_writes_weights_and_card_and_goes_on_from_its_checkpoint(tmp_path, caplog):
    rng = np.random.default_rng(6)
    write_texture_models(tmp_path / "texture", tmp_path / "naive")
    houses = [house_of_one_colour(rng) for _ in range(4)]
    np.savez(
        tmp_path / "houses.npz",
        house=np.repeat(np.arange(4), 4),
        types=np.concatenate([house.types for house in houses]),
        edges=np.concatenate([house.edges + 4 * k for k, house in enumerate(houses)], axis=1),
        crops=rng.integers(256, size=(16, len(SURFACES), 128, 128, 3), dtype=np.uint8),
        plain=np.repeat([True, False, True, False], 4),
    )
    inputs = (tmp_path / "houses.npz", tmp_path / "texture", tmp_path / "naive")
    settings = PropagationSettings(steps=2, batch=2)
    checkpoint = tmp_path / "propagation.checkpoint"
    for run in ("a", "b"):  # the second goes on from the first's last step
        paths = (tmp_path / f"{run}.safetensors", tmp_path / f"{run}.md")
        with caplog.at_level("INFO"):
            train_propagation(*inputs, *paths, settings=settings, seed=1, checkpoint=checkpoint)
    assert caplog.messages.count("propagation: goes on from step 2") == 1
    assert (tmp_path / "a.safetensors").read_bytes() == (tmp_path / "b.safetensors").read_bytes()
    network, means = load_propagation(tmp_path / "a.safetensors")
    assert isinstance(network, PointerNetwork) and means.embedding.shape == (12, 3, 11)
    card = (tmp_path / "a.md").read_text()
    seen = "3 synthetic houses (33% plain), 1 more held out"
    for text in (seen, "Plain homes, photos' light", "| gated (the paper's) |", "`steps` 2"):
        assert text in card
