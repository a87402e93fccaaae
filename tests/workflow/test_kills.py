"""A killed run goes on by the same words, to the same bytes (benchmarks/kills.py: 100 kills)."""

from clones import ROOT
from kills import digests, house_command, kill_often, strays

PLAN = ROOT / "resources" / "examples" / "plan.json"


def test_a_killed_run_ends_as_an_undisturbed_one(tmp_path):
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    kill_often(house_command(PLAN, whole), 0, 0.0, seed=0)
    hit = kill_often(house_command(PLAN, killed), 2, 12.0, seed=1)
    assert hit > 0
    assert digests(killed, but=["work"]) == digests(whole, but=["work"])
    assert strays(killed) == []
