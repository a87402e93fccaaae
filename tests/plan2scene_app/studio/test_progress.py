"""What a run's log tells."""

from plan2scene_app.studio.progress import read_progress

START = """\
Building DAG of jobs...
Job stats:
job              count
-------------  -------
crops                1
floorplan            1
masks                1
total                3

Select jobs to execute...
[Sun Nov 22 06:34:31 2026]
localrule floorplan:
    input: dataset/plan.json
[Sun Nov 22 06:34:31 2026]
rule masks:
    input: dataset/photos/a.jpg
WARNING file plan.json, house home: expected rooms that don't overlap, found 1.20 m2
Finished jobid: 4 (Rule: floorplan)
1 of 3 steps (33%) done
"""
FAULT = """\
ERROR file photos/a.jpg, house home: expected a JPEG, found text
Error in rule masks:
    message: None
ERROR the workflow failed; its logs are in house/work/logs
"""


def states(lines):
    return {stage["rule"]: stage["state"] for stage in read_progress(lines).stages()}


def test_stages_are_those_of_this_run_in_the_order_of_the_work():
    found = states(START.splitlines())
    assert list(found) == ["floorplan", "masks", "crops"]
    assert found == {
        "floorplan": "done",
        "masks": "running",
        "crops": "waiting",
    }


def test_a_failed_job_is_one_line():
    progress = read_progress((START + FAULT).splitlines())
    assert states((START + FAULT).splitlines())["masks"] == "failed"
    assert progress.fault == "file photos/a.jpg, house home: expected a JPEG, found text"
    assert progress.warnings == [
        "file plan.json, house home: expected rooms that don't overlap, found 1.20 m2"
    ]


def test_nothing_told_yet():
    assert read_progress([]).stages() == []
