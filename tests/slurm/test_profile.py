from concurrent.futures import ThreadPoolExecutor

import pytest
from clones import demo_rows, make_clone
from submit import submit

pytestmark = pytest.mark.slurm

#: Jobs that need nobody, and what becomes of each.
THREE = """
rule all:
    input: "fine", "cancelled", "large"
rule fine:
    output: "fine"
    shell: "echo $SLURM_JOB_PARTITION > {output}"
rule cancelled:
    output: "cancelled"
    shell: "scancel $SLURM_JOB_ID; sleep 60; touch {output}"
rule large:
    output: "large"
    resources: mem_mb=400
    shell: "python3 -c 'import time; x = bytes(b\\"x\\" * 700 * 2**20); time.sleep(60)'"
"""


@pytest.fixture(scope="module")
def runs(slurm, tmp_path_factory):
    """The two runs below at once, since both mostly wait for SLURM: folder and finished process."""
    clone = make_clone(tmp_path_factory.mktemp("houses") / "clone", demo_rows()[:2])
    good, bad = (row["house"] for row in demo_rows()[:2])
    plan = clone.root / "data" / demo_rows()[1]["plan"]
    plan.write_text(plan.read_text()[:200])
    houses = "results/tiny/houses"
    targets = [f"{houses}/{good}/crops.parquet", f"{houses}/{bad}/scene.json"]
    library = {"PYTHONPATH": str(clone.root / "src")}
    three = tmp_path_factory.mktemp("three")
    (three / "Snakefile").write_text(THREE)
    with ThreadPoolExecutor(2) as pool:
        made = pool.submit(submit, slurm, clone.root, "--retries", "0", *targets, **library)
        ended = pool.submit(submit, slurm, three, "--retries", "0", SBATCH_PARTITION="other")
        return {"houses": (clone.root, made.result()), "three": (three, ended.result())}


def test_a_house_is_made_and_a_broken_one_beside_it_is_named(runs):
    root, run = runs["houses"]
    good, bad = (row["house"] for row in demo_rows()[:2])
    base = root / "results" / "tiny" / "houses"
    assert run.returncode == 1
    assert {path.name for path in (base / good).iterdir()} >= {
        "scene.json",
        "masks",
        "crops.parquet",
    }
    assert f"house {bad}: expected" in run.stdout, run.stdout[-3000:]
    assert not (base / bad / "scene.json").exists()
    # Three jobs of the good house are one submission.
    assert run.stdout.count("submitted with SLURM jobid") == 2


def test_cancelled_and_too_large_jobs_do_not_hang_the_others(runs):
    folder, run = runs["three"]
    assert run.returncode == 1 and (folder / "fine").read_text() == "other\n"
    assert "SLURM status is: 'CANCELLED'" in run.stdout, run.stdout[-3000:]
    # Without control groups the state is FAILED, and SLURM's own line says why.
    assert "exceeded memory limit" in run.stdout, run.stdout[-3000:]
    assert not (folder / "cancelled").exists() and not (folder / "large").exists()
