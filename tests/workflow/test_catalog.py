"""The two houses of ``.test/``, which Snakemake's workflow catalog runs."""

import shutil

from clones import ROOT, Clone


def test_the_catalog_plans_two_houses_of_the_demo(tmp_path):
    shutil.copytree(ROOT / ".test" / "config", tmp_path / ".test" / "config")
    (tmp_path / "resources").symlink_to(ROOT / "resources")
    jobs = Clone(tmp_path).jobs("-s", str(ROOT / "Snakefile"), "--directory", ".test")
    assert {house for _, house in jobs if house} == {"flat_test_002", "flat_test_003"}
    assert ("paper_table", "") in jobs
