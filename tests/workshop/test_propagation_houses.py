from functools import partial

import numpy as np

from plan2scene.colour import median_colour
from plan2scene_workshop.homes.style import assign_materials
from plan2scene_workshop.propagation import data
from plan2scene_workshop.propagation.run import split_graphs


def test_houses_are_graphs_with_a_crop_of_every_surface(tmp_path, monkeypatch):
    monkeypatch.setattr(data, "assign_materials", partial(assign_materials, size_px=64))
    for name in "ab":
        data.write_training_houses(tmp_path / name, count=3, seed=0)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
    with np.load(tmp_path / "a") as made:
        rooms = len(made["house"])
        assert made["crops"].shape == (rooms, 3, 128, 128, 3) and made["crops"].dtype == np.uint8
        colours = np.array([[median_colour(crop) for crop in room] for room in made["crops"]])
        embeddings = np.concatenate([np.zeros((rooms, 3, 8)), colours], axis=2)
        graphs = split_graphs(made["house"], made["types"], made["edges"], embeddings)
        plain = [made["plain"][made["house"] == k] for k in range(3)]
    assert sum(len(graph.room_ids) for graph in graphs) == rooms
    assert all(graph.edges.max() < len(graph.room_ids) for graph in graphs)
    assert all(flags.all() == flags.any() for flags in plain) and 0 < sum(f[0] for f in plain) < 3
    # Crops of a plain home's walls are of one paint for the most part.
    for graph, flags in zip(graphs, plain, strict=True):
        walls = graph.embeddings[:, 1, 8:]
        near = np.abs(walls - np.median(walls, axis=0)).max(axis=1) < 0.1
        assert not flags[0] or near.mean() > 0.5
