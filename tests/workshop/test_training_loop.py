import numpy as np
import pytest
import torch
from torch import nn

from plan2scene_workshop.training.loop import Trainer, TrainerOptions, cosine


def trainer(**changes):
    """Return a trainer of a small network with dropout and batch statistics on y = sum(x)."""
    torch.manual_seed(0)
    network = nn.Sequential(nn.Linear(3, 8), nn.BatchNorm1d(8), nn.Dropout(0.2), nn.Linear(8, 1))

    def loss(step, rng):
        x = torch.from_numpy(rng.random((16, 3), dtype=np.float32))
        error = (network(x)[:, 0] - x.sum(1)).square().mean()
        return {"error": error, "size": 1e-4 * network[0].weight.square().mean()}

    def evaluate(network):
        return -float((network(torch.eye(3))[:, 0] - 1.0).abs().mean())

    options = TrainerOptions(
        "toy",
        seed=changes.pop("seed", 3),
        steps=changes.pop("steps", 12),
        schedule=lambda step: cosine(step, 12, rise=2),
        clip_norm=1.0,
        **{"evaluate_every": 3, "average_decay": 0.9, **changes},
    )
    optimiser = torch.optim.AdamW(network.parameters(), lr=0.05)
    return Trainer(network, loss, optimiser, options, evaluate=evaluate, run="settings")


def same(first, second):
    states = first.network.state_dict(), second.network.state_dict()
    equal = all(torch.equal(value, states[1][name]) for name, value in states[0].items())
    return equal and (first.step, first.score) == (second.step, second.score)


def test_the_same_seed_gives_the_same_weights_and_another_does_not():
    whole = trainer().fit()
    assert same(whole, trainer().fit()) and not same(whole, trainer(seed=4).fit())


@pytest.mark.parametrize("stopped", [1, 7])
def test_a_stopped_run_ends_as_one_that_never_stopped(tmp_path, stopped):
    path = tmp_path / "toy.checkpoint"
    first = trainer()
    for _ in range(stopped):
        first.train_step()
        if first.step % 3 == 0:
            first._evaluate(first.evaluate)
    first.save(path)
    again = trainer()
    assert again.resume(path)
    whole = trainer().fit()
    assert same(again.fit(path), whole)
    ended = trainer()
    assert ended.resume(path) and same(ended.fit(), whole)


def test_fit_writes_checkpoints_that_another_run_does_not_take(tmp_path):
    path = tmp_path / "toy.checkpoint"
    run = trainer(checkpoint_every=5)
    remove, run.save = run.save, lambda path: remove(path.with_name(f"{run.step}"))
    run.fit(path)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["10", "12", "5"]
    assert trainer().resume(tmp_path / "10")
    other = trainer(seed=4)
    assert not other.resume(tmp_path / "10") and other.step == 0
    assert not trainer().resume(tmp_path / "none")
