"""What the sweep, the ablation and the user study ask of the workflow (dry runs)."""

from collections import Counter

import pytest
from clones import demo_rows, make_clone


@pytest.fixture(scope="module")
def bare(tmp_path_factory):
    """Two houses, nothing made."""
    return make_clone(tmp_path_factory.mktemp("bare") / "clone", demo_rows()[:2])


def test_a_house_is_one_job_of_the_sweep_and_one_of_the_ablation(bare):
    rules = Counter(rule for rule, _ in bare.jobs("sweep", "ablation"))
    assert (rules["sweep_house"], rules["ablation_house"]) == (2, 2)
    assert (rules["sweep"], rules["ablation"]) == (1, 1)
    assert not rules.keys() & {"textures", "metrics", "propagate", "surfaces"}


def test_the_study_needs_the_textures_of_its_methods_alone(bare, tmp_path):
    config = tmp_path / "study.yaml"
    config.write_text("study: {houses: 1, pairs: [[projection, medoid_colour]]}\n")
    jobs = bare.jobs("study", "--configfile", "config/config.yaml", str(config))
    assert Counter(rule for rule, _ in jobs)["textures"] == 2
    assert len({house for _, house in jobs if house}) == 1


def test_without_answers_the_study_has_no_result(bare):
    rules = {rule for rule, _ in bare.jobs("study_result")}
    assert {"study_result", "study", "study_house"} <= rules
