import shlex
import shutil
from collections import Counter

import pytest
from clones import ROOT, Clone, demo_rows, make_clone


@pytest.fixture(scope="module")
def bare(tmp_path_factory):
    return make_clone(tmp_path_factory.mktemp("bare") / "clone", demo_rows()[:2])


def test_the_jobs_of_a_house_and_those_of_its_sweep_and_ablation(bare):
    rules = Counter(rule for rule, house in bare.jobs("all") if house)
    once = {"floorplan", "masks", "places", "crops", "contact_sheet", "embeddings"}
    once |= {"materials", "propagated", "patterns", "textures", "table_textures", "metrics"}
    once |= {"texture_sheet", "paint", "house", "pictures", "viewer"}
    assert rules == dict.fromkeys(once, 2)
    assert not (bare.root / "results").exists()  # a dry run writes nothing
    rules = Counter(rule for rule, _ in bare.jobs("sweep", "ablation"))
    assert (rules["sweep_house"], rules["ablation_house"]) == (2, 2)
    assert (rules["sweep"], rules["ablation"]) == (1, 1) and rules["metrics"] == 2


def test_one_method_of_one_house_can_be_asked_for(bare):
    house = bare.houses()[0]
    copies = (f"results/tiny/drop_{d}/{house}/textures" for d in ("0.6/crop", "0.0/projection"))
    rules = Counter(rule for rule, _ in bare.jobs(*copies))
    assert rules["textures"] == 2 and rules["texture_library"] == 1
    assert "table_textures" not in rules
    # A method that takes no tile of the library does not wait for it, the 3D house for no picture.
    rules = {rule for rule, _ in bare.jobs(f"results/tiny/houses/{house}/house.glb")}
    assert "textures" in rules
    assert not rules & {"texture_library", "table_textures", "pictures", "viewer"}


def test_without_a_finished_house_there_is_no_partial_table(bare):
    run = bare.snakemake("partial_table")
    assert run.returncode != 0
    assert run.stdout.endswith("expected a finished house in results/tiny, found none\n")


def test_a_lock_that_a_kill_left_is_told_with_the_command_that_helps(bare):
    locks = bare.root / ".snakemake" / "locks"
    locks.mkdir(parents=True, exist_ok=True)
    target = f"results/tiny/houses/{bare.houses()[0]}/scene.json"
    (locks / "0.output.lock").write_text(target + "\n")
    run = bare.snakemake(target)
    assert run.returncode != 0
    command = run.stdout.split("plan2scene: if none runs here: ")[1].splitlines()[0]
    assert shlex.split(command)[:2] == ["snakemake", "--unlock"]
    assert bare.snakemake(*shlex.split(command)[1:]).returncode == 0
    assert not locks.exists()


def test_every_stage_has_a_target_over_the_data_set(bare):
    stages = ["plans", "masks", "places", "crops", "embeddings", "surfaces", "materials"]
    stages += ["propagated", "textures", "meshes", "metrics"]
    rules = Counter(rule for rule, house in bare.jobs(*(f"all_{s}" for s in stages)) if house)
    once = ["floorplan", "masks", "places", "crops", "embeddings", "textures", "table_textures"]
    once += ["materials", "propagated", "house", "metrics"]
    assert {rules[rule] for rule in once} == {2}
    assert not rules.keys() & {"pictures", "viewer", "contact_sheet", "texture_sheet"}


def test_a_batch_plans_only_its_houses(tmp_path):
    rows = demo_rows()[:3]
    names = [row["house"] for row in rows]
    dataset = {"name": "tiny", "root": "data", "table": "houses.tsv", "splits": ["test"]}
    clone = make_clone(tmp_path / "clone", rows, dataset=dataset | {"houses": names[1:2]})
    (clone.root / "data" / rows[0]["plan"]).unlink()
    jobs = clone.jobs("all")
    assert {house for _, house in jobs} == {names[1], ""} and ("paper_table", "") in jobs
    assert ("house", names[1]) in jobs


def test_the_workflow_in_batches_leaves_the_table_to_the_last(bare):
    jobs = bare.jobs("--batch", "all=1/3", "--", "all")
    assert {house for _, house in jobs} - {""} == {demo_rows()[0]["house"]}
    assert "paper_table" not in {rule for rule, _ in jobs}


def test_the_catalog_plans_two_houses_of_the_demo(tmp_path):
    """Of the two houses of ``.test/``, which Snakemake's workflow catalog runs."""
    shutil.copytree(ROOT / ".test" / "config", tmp_path / ".test" / "config")
    for name in ("resources", "src"):
        (tmp_path / name).symlink_to(ROOT / name)
    jobs = Clone(tmp_path).jobs("-s", str(ROOT / "Snakefile"), "--directory", ".test")
    assert {house for _, house in jobs if house} == {"flat_test_002", "flat_test_003"}
    assert ("paper_table", "") in jobs
    (tmp_path / "my.yaml").write_text("dataset: {houses: [flat_test_001]}\n")  # no config/ here
    jobs = Clone(tmp_path).jobs("-s", str(ROOT / "Snakefile"), "--configfile", "my.yaml")
    assert {house for _, house in jobs if house} == {"flat_test_001"}
