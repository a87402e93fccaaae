import pytest

from plan2scene.errors import InputError
from plan2scene_app.workflow.jobs import job


def test_a_fault_of_the_input_is_one_line_and_exit_code_1(tmp_path, capsys):
    log = tmp_path / "logs" / "x.log"
    with pytest.raises(SystemExit) as stop, job(log):
        raise InputError("a photo", "no such file", file="a.jpg", house="h", room="r")
    line = "file a.jpg, house h, room r: expected a photo, found no such file"
    assert stop.value.code == 1 and log.read_text() == f"ERROR {line}\n"
    assert capsys.readouterr().err == f"ERROR {line}\n"
    assert str(InputError("x", "two\nlines\x1b[31m", file="a\nb")).isprintable()


def test_a_full_disk_is_one_line(tmp_path, capfd):
    with pytest.raises(SystemExit), job(tmp_path / "log.txt"):
        raise OSError(28, "No space left on device", str(tmp_path / ".tmp_1_2_3.png"))
    line = f"ERROR file {tmp_path}: expected free space on the disk, found No space left on device"
    assert (tmp_path / "log.txt").read_text().splitlines() == [line]
    assert capfd.readouterr().err.splitlines() == [line]


def test_a_fault_of_ours_keeps_its_traceback_and_control_c_says_nothing(tmp_path, capsys):
    log = tmp_path / "x.log"
    with pytest.raises(SystemExit) as stop, job(log):
        raise KeyboardInterrupt
    assert stop.value.code == 130 and (log.read_text(), capsys.readouterr().err) == ("", "")
    with pytest.raises(ZeroDivisionError), job(log):
        raise ZeroDivisionError
    assert "Traceback" in log.read_text()
