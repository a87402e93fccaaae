"""Copies of the workflow with houses of the demo, in which tests run Snakemake for real."""

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[2]
DEMO = ROOT / "resources" / "demo"


@dataclass(frozen=True)
class Clone:
    """A working copy: edits in it never touch the repository."""

    root: Path

    def snakemake(self, *arguments, cores=2):
        """Run Snakemake in the copy, with the copy's library first on the path."""
        return subprocess.run(
            [sys.executable, "-m", "snakemake", "--cores", str(cores), *arguments],
            cwd=self.root,
            env=(os.environ | {"PYTHONPATH": str(self.root / "src")}),
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            check=False,
        )

    def jobs(self, *arguments):
        """Return (rule, house or '') of every job that a dry run would do."""
        run = self.snakemake("--dry-run", *arguments)
        assert run.returncode == 0, run.stdout
        jobs: list[tuple[str, str]] = []
        for line in run.stdout.splitlines():
            if line.startswith(("rule ", "localrule ")):
                jobs.append((line.split()[1].rstrip(":"), ""))
            elif line.strip().startswith("wildcards:") and "house=" in line:
                jobs[-1] = (jobs[-1][0], line.split("house=")[1].split(",")[0].strip())
        return jobs

    def houses(self):
        lines = (self.root / "data" / "houses.tsv").read_text().splitlines()[1:]
        return [line.split("\t")[0] for line in lines]


def demo_rows():
    """Return the rows of the demo's house table, houses of few photos first."""
    lines = (DEMO / "houses.tsv").read_text().splitlines()
    header = lines[0].split("\t")
    rows = [dict(zip(header, line.split("\t"), strict=True)) for line in lines[1:]]
    return sorted(rows, key=lambda row: (row["photos"].count("|"), row["house"]))


def make_clone(root, rows, **changes):
    """Copy workflow and config to `root`, with those houses of the demo as its data set."""
    root.mkdir(parents=True, exist_ok=True)
    ignore = shutil.ignore_patterns("*.egg-info", "*.pyc.*")  # nor what is being compiled now
    for name in ("workflow", "config", "envs", "src"):  # with what Python has compiled
        shutil.copytree(ROOT / name, root / name, ignore=ignore)
    shutil.copy(ROOT / "Snakefile", root)
    (root / "profiles").symlink_to("workflow/profiles")
    (root / "resources").mkdir()
    (root / "resources" / "models").symlink_to(ROOT / "resources" / "models")
    data = root / "data"
    data.mkdir()
    for row in rows:
        for name in (row["plan"], row["assignment"], *(f"photos/{p}" for p in photos_of(row))):
            if name and (DEMO / name).is_file():
                (data / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(DEMO / name, data / name)
    shutil.copy2(DEMO / "unobserved_photos.json", data)
    write_table(data, rows)
    config = yaml.safe_load((ROOT / "config" / "config.yaml").read_text())
    config["dataset"] |= {"name": "tiny", "root": "data"}
    config |= changes
    (root / "config" / "config.yaml").write_text(yaml.safe_dump(config))
    return Clone(root)


def photos_of(row):
    return [name for name in row["photos"].split("|") if name]


def write_table(data, rows):
    columns = ["house", "split", "plan", "assignment", "photos"]
    lines = ["\t".join(columns), *("\t".join(row[c] for c in columns) for row in rows)]
    data.mkdir(parents=True, exist_ok=True)
    (data / "houses.tsv").write_text("\n".join(lines) + "\n")
