import signal
import subprocess
import sys
import time

import psutil
import pytest

from plan2scene_app.bound_process import run_bound

#: Starts a process that starts another one, prints both numbers and sleeps; deaf to SIGINT or not.
COMMAND = """
import os, signal, subprocess, sys, time
if {deaf}:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(99)"])
print(os.getpid(), child.pid, flush=True)
time.sleep(99)
"""
STARTER = """
import sys
import time
from plan2scene.errors import WorkflowError
from plan2scene_app.bound_process import run_bound
try:
    run_bound([sys.executable, "-c", {command!r}])
except WorkflowError as error:
    print(error)
"""


def test_the_exit_code_is_the_commands():
    assert run_bound([sys.executable, "-c", "import sys; sys.exit(3)"]) == 3
    kill = "import os, signal; os.kill(os.getpid(), signal.SIGKILL)"
    assert run_bound([sys.executable, "-c", kill]) == 128 + signal.SIGKILL


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP", "SIGKILL"])
def test_a_signal_to_the_starter_alone_ends_all(name):
    code = STARTER.format(command=COMMAND.format(deaf=name == "SIGKILL"))
    starter = subprocess.Popen([sys.executable, "-c", code], text=True, stdout=subprocess.PIPE)
    started = [psutil.Process(int(number)) for number in starter.stdout.readline().split()]
    assert len(started) == 2
    starter.send_signal(getattr(signal, name))
    starter.wait(timeout=10)
    if name != "SIGKILL":
        assert starter.stdout.read() == (f"ended by {name}; the same command goes on from there\n")
    _, alive = psutil.wait_procs(started, timeout=8)
    assert alive == []


def test_control_c_in_the_first_seconds_is_one_line():
    # A shell's job in the background starts with the signal ignored.
    code = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
    code += "print(flush=True); from plan2scene_app.start import main; main()"
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    command = subprocess.Popen([sys.executable, "-c", code, "--help"], text=True, **pipes)
    command.stdout.readline()
    time.sleep(0.05)
    command.send_signal(signal.SIGINT)
    assert command.communicate(timeout=20)[1] == "ERROR ended by SIGINT\n"
    assert command.returncode == 130
