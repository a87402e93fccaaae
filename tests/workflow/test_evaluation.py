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
    # Both compare with the features of the crops.
    assert rules["metrics"] == 2


def test_what_the_table_needs_of_a_house(bare):
    rules = Counter(rule for rule, _ in bare.jobs("results/tiny/tables/paper_table.csv"))
    # Tiles of the 3D house are taken, those of other methods and drops made.
    assert rules["table_textures"] == rules["embeddings"] == rules["textures"] == 2
    assert rules["metrics"] == rules["materials"] == rules["propagated"] == 2
    assert "house" not in rules and "texture_sheet" not in rules


def test_accent_walls_are_no_part_of_the_table(bare, tmp_path):
    config = tmp_path / "walls.yaml"
    config.write_text("house: {walls: wall}\n")
    configs = ("--configfile", "config/config.yaml", str(config))
    rules = Counter(rule for rule, _ in bare.jobs("results/tiny/tables/paper_table.csv", *configs))
    assert rules["table_textures"] == 2
    assert "textures" not in rules


def test_the_jobs_of_a_house(bare):
    rules = Counter(rule for rule, house in bare.jobs("all") if house)
    once = {"floorplan", "masks", "places", "crops", "contact_sheet", "embeddings"}
    once |= {"materials", "propagated", "textures", "table_textures", "metrics", "texture_sheet"}
    assert rules == dict.fromkeys(once | {"paint", "house", "pictures", "viewer"}, 2)


def test_a_house_is_made_without_table_and_pictures(bare):
    house = bare.houses()[0]
    rules = Counter(rule for rule, _ in bare.jobs(f"results/tiny/houses/{house}/house.glb"))
    assert rules["textures"] == 1
    assert not rules.keys() & {"table_textures", "pictures", "viewer", "contact_sheet"}


def test_one_method_of_one_house_can_be_asked_for(bare):
    house = bare.houses()[0]
    for drop, method in (("0.6", "crop"), ("0.0", "projection")):
        jobs = bare.jobs(f"results/tiny/drop_{drop}/{method}/{house}/textures")
        rules = Counter(rule for rule, _ in jobs)
        assert rules["textures"] == rules["texture_library"] == 1
        assert "table_textures" not in rules
    # A method that takes no tile of the library does not wait for it.
    jobs = bare.jobs(f"results/tiny/drop_0.6/synth/{house}/textures")
    assert "texture_library" not in {rule for rule, _ in jobs}


def test_an_unknown_house_is_one_line_with_the_table_and_the_nearest_names(bare):
    house = bare.houses()[0]
    run = bare.snakemake(f"results/tiny/houses/{house}x/house.glb")
    assert run.returncode != 0
    (line,) = [text for text in run.stdout.splitlines() if f"{house}x: expected" in text]
    assert "data/houses.tsv" in line and house in line.split("found")[1]
    assert "Traceback" not in run.stdout


def test_without_a_finished_house_there_is_no_partial_table(bare):
    run = bare.snakemake("partial_table")
    assert run.returncode != 0
    assert run.stdout.endswith("expected a finished house in results/tiny, found none\n")


def test_a_dry_run_writes_no_result(bare):
    assert bare.jobs("all")
    assert not (bare.root / "results").exists()


def test_every_stage_has_a_target_over_the_data_set(bare):
    stages = ["plans", "masks", "places", "crops", "embeddings", "surfaces", "materials"]
    stages += ["propagated", "textures", "meshes", "metrics"]
    rules = Counter(rule for rule, house in bare.jobs(*(f"all_{s}" for s in stages)) if house)
    once = ["floorplan", "masks", "places", "crops", "embeddings", "textures", "table_textures"]
    once += ["materials", "propagated", "house", "metrics"]
    assert {rules[rule] for rule in once} == {2}
    # Nothing that is only looked at.
    assert not rules.keys() & {"pictures", "viewer", "contact_sheet", "texture_sheet"}
