import cluster
import pytest
from clones import demo_rows, make_clone
from submit import submit

pytestmark = pytest.mark.slurm

#: Takes more than the first attempt is given; each attempt leaves a line.
GROWING = """
rule growing:
    output: "made"
    resources: mem_mb=lambda wildcards, attempt: 500 * attempt
    shell:
        "echo attempt >> attempts; "
        "python -c 'import time; x = 600 * 2**20 * b\\"x\\"; time.sleep(5)' && touch {output}"
"""


def test_a_job_beyond_its_memory_is_given_more(slurm, tmp_path):
    (tmp_path / "Snakefile").write_text(GROWING)
    run = submit(slurm, tmp_path, "made")
    assert run.returncode == 0, run.stdout[-3000:]
    assert "exceeded memory limit" in run.stdout
    assert (tmp_path / "attempts").read_text().count("attempt") >= 2


def test_a_cluster_that_would_hide_a_jobs_end_is_told_at_once(tmp_path):
    if cluster.missing():
        pytest.skip(cluster.missing())
    clone = make_clone(tmp_path / "clone", demo_rows()[:1])
    target = f"results/tiny/houses/{demo_rows()[0]['house']}/scene.json"
    with cluster.cluster(min_job_age=60) as made:
        run = submit(made, clone.root, target, PYTHONPATH=str(clone.root / "src"))
    assert run.returncode == 1
    line = "expected accounting or a longer memory, found MinJobAge=60"
    assert line in run.stdout, run.stdout[-3000:]
    assert "submitted with" not in run.stdout


def test_a_whole_house_is_two_submissions_and_the_same_bytes(slurm, tmp_path):
    house = demo_rows()[0]["house"]
    target = f"results/tiny/houses/{house}/house.glb"
    made = []
    for name in ("cluster", "alone"):
        clone = make_clone(tmp_path / name, demo_rows()[:1])
        library = {"PYTHONPATH": str(clone.root / "src")}
        run = submit(slurm, clone.root, target, **library) if name == "cluster" else None
        run = run or clone.snakemake(target)
        assert run.returncode == 0, run.stdout[-3000:]
        made.append((clone.root / target).read_bytes())
        if name == "cluster":
            assert run.stdout.count("submitted with SLURM jobid") == 2
    assert made[0] == made[1]
