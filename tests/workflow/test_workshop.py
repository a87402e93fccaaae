import os
import subprocess
import sys

import pytest
import yaml
from places import ROOT

from plan2scene.metrics.substance_network import load_substance_network
from plan2scene_app.tracing.segmenter import load_plan_segmenter
from plan2scene_app.tracing.settings import FIXTURE_LABELS
from plan2scene_app.workflow.house_table import read_table

SMALL = {"photos": [1, 1], "height": 32, "width": 32, "samples_per_pixel": 1, "tile_px": 32}
SHORT = dict(drawings=2, batch=1, side=64, steps=2, evaluate_every=2, held_out=1, figures=1)
TINY = {
    "synthetic": SMALL | {"root": "data/tiny", "houses": {"train": 1, "val": 0, "test": 0}},
    "training": dict(
        materials={"procedural": 8, "held_out": 4},
        features={"steps": 2, "batch": 4, "held_out_crops": 8},
        **dict.fromkeys(("plans", "fixtures"), SHORT),
    ),
}
MODELS = "results/training/models"


@pytest.fixture
def run(tmp_path):
    (tmp_path / "workshop").symlink_to(ROOT / "workshop")
    (tmp_path / "tiny.yaml").write_text(yaml.safe_dump(TINY))
    paths = os.pathsep.join(str(ROOT / part) for part in ("src", "workshop/src"))

    def snakemake(*arguments):
        done = subprocess.run(
            [sys.executable, "-m", "snakemake", "-s", "workshop/Snakefile", "--cores", "2"]
            + [*arguments, "--configfile", "tiny.yaml"],
            cwd=tmp_path,
            env=os.environ | {"PYTHONPATH": paths},
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            check=False,
        )
        assert done.returncode == 0, done.stdout[-6000:]
        return done.stdout

    return snakemake


def test_data_and_models_are_made(run, tmp_path):
    pytest.importorskip("mitsuba")
    run("data", *(f"{MODELS}/{name}.safetensors" for name in ("features", "fixtures", "plans")))
    assert len(read_table(tmp_path / "data" / "tiny" / "houses.tsv").houses) == 1
    load_substance_network(tmp_path / MODELS / "features.safetensors")
    load_plan_segmenter(tmp_path / MODELS / "plans.safetensors")
    load_plan_segmenter(tmp_path / MODELS / "fixtures.safetensors", FIXTURE_LABELS)
    assert "`steps` 2," in (tmp_path / MODELS / "plans.md").read_text()
    card = (tmp_path / MODELS / "features.md").read_text()
    assert "- 8 procedural materials." in card and "`steps` 2" in card
    made = {path.name for path in (tmp_path / MODELS).parent.iterdir()}
    assert made == {"models", "materials.npz"}  # no checkpoint stays


def test_every_model_has_a_rule(run):
    planned = run("train", "--dry-run")
    for name in ("texture", "naivesynth", "features", "segmentation", "propagation", "fixtures"):
        assert f"{MODELS}/{name}.safetensors" in planned
