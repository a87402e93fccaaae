"""What the events of a run say of its stages."""

import json

from plan2scene_app.studio.runs import Progress, read_progress

START = [
    {"event": "warning", "warnings": ["rooms overlap"]},
    {"event": "planned", "jobs": {"crops": 2, "floorplan": 1, "masks": 1, "all": 1}},
    {"event": "started", "rule": "floorplan", "house": "home"},
    {"event": "started", "rule": "masks", "house": "home"},
    {"event": "started", "rule": "crops", "house": "home"},
    {"event": "finished", "rule": "floorplan", "house": "home", "warnings": ["rooms overlap"]},
    {"event": "finished", "rule": "crops", "house": "home", "warnings": []},
]
FAULT = [
    {"event": "failed", "rule": "masks", "house": "home", "message": "expected a JPEG, found text"},
    {"event": "error", "message": "Exiting because a job failed"},
]


def told(tmp_path, events, end=""):
    file = tmp_path / "events.jsonl"
    file.write_text("".join(json.dumps(event) + "\n" for event in events) + end)
    return read_progress(file)


def states(progress):
    return {stage["rule"]: stage["state"] for stage in progress.stages()}


def test_stages_are_those_of_this_run_in_the_order_of_the_work(tmp_path):
    progress = told(tmp_path, START, end='{"event": "fin')
    assert list(states(progress).items()) == [
        ("floorplan", "done"),
        ("masks", "running"),
        ("crops", "running"),
        ("all", "waiting"),
    ]
    assert progress.warnings == ["rooms overlap"]


def test_the_first_failed_job_says_why(tmp_path):
    progress = told(tmp_path, START + FAULT)
    assert states(progress)["masks"] == "failed"
    assert progress.fault == "expected a JPEG, found text"


def test_before_the_first_event(tmp_path):
    assert read_progress(tmp_path / "none").stages() == Progress().stages() == []
