"""What a failed run leaves out of date goes, all else stays."""

from plan2scene.workflow.stale import remove_outdated


def test_what_lies_downstream_of_a_failed_job_goes(tmp_path):
    names = ("a.plan", "a.glb", "a.html", "b.scene", "b.glb", "b.html", "table.csv")
    path = {name: str(tmp_path / name) for name in (*names, "a.scene", "missing.csv")}
    for name in names:
        (tmp_path / name).write_text("old")
    jobs = [
        ([path["a.glb"], path["b.glb"]], [path["table.csv"]]),
        ([path["a.glb"]], [path["a.html"]]),
        ([path["a.scene"], path["missing.csv"]], [path["a.glb"]]),  # the latter is nobody's output
        ([path["a.plan"]], [path["a.scene"]]),
        ([path["b.glb"]], [path["b.html"]]),  # not yet made anew, but from what is there
    ]
    assert sorted(remove_outdated(jobs)) == [path[n] for n in ("a.glb", "a.html", "table.csv")]
    assert {p.name for p in tmp_path.iterdir()} == {"a.plan", "b.scene", "b.glb", "b.html"}
    assert remove_outdated([]) == []
