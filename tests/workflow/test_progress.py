import io
import json
import logging

import pytest

interface = pytest.importorskip("snakemake_interface_logger_plugins.common")
from snakemake_logger_plugin_plan2scene import LogHandler, LogHandlerSettings  # noqa: E402

EVENT = interface.LogEvent


class Terminal(io.StringIO):
    def isatty(self):
        return True


def events(handler, *, seconds=2.5):

    def tell(created, level=logging.INFO, message="", **fields):
        record = logging.makeLogRecord({"levelno": level, "msg": message, **fields})
        record.created = created
        handler.emit(record)

    tell(0.0, event=EVENT.ERROR, level=logging.ERROR, message="no such target")
    tell(0.0, event=EVENT.RUN_INFO, stats={"crops": 1, "paper_table": 1, "total": 2})
    crops = {"jobid": 7, "rule_name": "crops", "wildcards": {"house": "flat_1"}}
    tell(1.0, event=EVENT.JOB_INFO, **crops)
    tell(1.2, event=EVENT.ERROR, level=logging.ERROR, message="its log says it better")
    tell(1.5, message="Select jobs to execute...")
    tell(1.0 + seconds, event=EVENT.JOB_FINISHED, job_id=7)
    tell(4.0, event=EVENT.JOB_INFO, jobid=0, rule_name="paper_table", wildcards={})
    tell(4.25, event=EVENT.JOB_FINISHED, job_id=0)
    tell(5.0, level=logging.ERROR, message="disk full")


def made(stream, settings=None):
    handler = LogHandler(None, settings)
    handler.stream = stream
    events(handler)
    return stream.getvalue()


def test_a_line_says_count_rule_house_and_seconds_and_a_terminal_gets_a_bar():
    lines = made(io.StringIO()).splitlines()
    assert lines.pop(0) == "no such target"
    assert [line.split() for line in lines] == [
        ["1", "of", "2", "crops", "flat_1", "2.5", "s"],
        ["2", "of", "2", "paper_table", "0.2", "s"],
        ["disk", "full"],
    ]
    text = made(Terminal())
    assert f"[{'#' * 15}{'.' * 15}]\r" in text and f"[{'#' * 30}]\n" in text


def test_events_go_to_a_file_as_json_lines(tmp_path):
    made(io.StringIO(), LogHandlerSettings(events=tmp_path / "events.jsonl"))
    lines = (tmp_path / "events.jsonl").read_text().splitlines()
    crops = {"rule": "crops", "house": "flat_1"}
    table = {"rule": "paper_table", "house": ""}
    assert [json.loads(line) for line in lines] == [
        {"event": "error", "message": "no such target"},
        {"event": "planned", "jobs": {"crops": 1, "paper_table": 1}},
        {"event": "started", **crops},
        {"event": "finished", **crops, "seconds": 2.5, "warnings": []},
        {"event": "started", **table},
        {"event": "finished", **table, "seconds": 0.25, "warnings": []},
        {"event": "error", "message": "disk full"},
    ]


def test_a_failed_job_is_a_line_with_what_its_log_says(tmp_path):
    (tmp_path / "plan.log").write_text("INFO read\nERROR house h: expected a room, found none\n")
    handler = LogHandler(None, None)
    handler.stream = io.StringIO()
    common = {"event": EVENT.JOB_ERROR, "levelno": logging.ERROR, "rule_msg": None}
    told = common | {"jobid": 1, "rule_name": "floorplan", "log": [str(tmp_path / "plan.log")]}
    silent = common | {"jobid": 2, "rule_name": "crops", "log": [str(tmp_path / "none.log")]}
    handler.emit(logging.makeLogRecord(told | {"indent": True}))
    handler.emit(logging.makeLogRecord(silent | {"indent": True}))
    handler.emit(logging.makeLogRecord(silent | {"indent": False}))
    first, second = handler.stream.getvalue().splitlines()
    assert first.split(maxsplit=2)[2] == "ERROR house h: expected a room, found none"
    assert second.endswith(f"see {tmp_path / 'none.log'}")
    handler.emit(logging.makeLogRecord({"msg": "Terminating processes on user request, this..."}))
    handler.emit(logging.makeLogRecord(silent | {"indent": False}))
    assert handler.stream.getvalue().splitlines()[2:] == []
