import http.client
import json
import subprocess
import sys
import time

import pytest
from places import PLAN
from studio_client import TOKEN, StudioClient

#: Stands for the workflow: works until a file `finish` lies in the home.
JOB = """
import json, sys, time
from pathlib import Path
home = Path(sys.argv[1])
def tell(**event):
    with (home / "run_events.jsonl").open("a") as file:
        file.write(json.dumps(event) + "\\n")
tell(event="planned", jobs={"floorplan": 1})
tell(event="started", rule="floorplan")
while not (home / "finish").exists():
    time.sleep(0.02)
tell(event="finished", rule="floorplan", warnings=[])
record = json.loads((home / "run.json").read_text())
(home / "new.json").write_text(json.dumps(record | {"state": "done"}))
(home / "new.json").replace(home / "run.json")
time.sleep(0.3)  # done, and not gone yet
"""
#: A studio in a process of its own; its first line is its port.
SERVER = """
import socket, sys, uvicorn
from pathlib import Path
from plan2scene_app.studio import runs
from plan2scene_app.studio.app import studio_app
runs.JOB = (sys.executable, "-c", sys.argv[3])
listener = socket.create_server(("127.0.0.1", 0))
port = listener.getsockname()[1]
print(port, flush=True)
app = studio_app(Path(sys.argv[1]), sys.argv[2], port, cores=1)
uvicorn.Server(uvicorn.Config(app, log_level="warning", ws="none")).run(sockets=[listener])
"""


@pytest.fixture
def servers(tmp_path):
    pytest.importorskip("uvicorn")
    pytest.importorskip("starlette")
    started = []

    def start():
        command = [sys.executable, "-c", SERVER, str(tmp_path), TOKEN, JOB]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        started.append(process)
        return process, StudioClient(int(process.stdout.readline())).ask

    yield start
    for process in started:
        process.kill()
        process.wait()
        process.stdout.close()


def state_when(ask, *states):
    for _ in range(400):
        found = ask("GET", "p/home/run")[1]
        if found["state"] in states and found["stages"]:
            return found
        time.sleep(0.05)
    raise AssertionError(found)


def test_a_killed_server_and_a_killed_job_lose_nothing(servers, tmp_path):
    first, ask = servers()
    ask("POST", "projects", {"name": "home"})
    state = ask("GET", "p/home/state")[1] | {"plan": json.loads(PLAN.read_text())}
    saved = ask("PUT", "p/home/state", state)[1]
    assert ask("POST", "p/home/run", {})[0] == 200
    first.kill()
    first.wait()
    with pytest.raises((ConnectionError, http.client.HTTPException)):
        ask("GET", "p/home/run")
    # The next server has what was saved, and sees the run, which nobody stopped, to its end.
    _, ask = servers()
    found = ask("GET", "p/home/state")[1]
    assert (found["plan"], found["revision"]) == (state["plan"], saved["revision"])
    assert state_when(ask, "running", "done")["state"] == "running"
    (tmp_path / "home" / "finish").touch()
    assert [s["state"] for s in state_when(ask, "done")["stages"]] == ["done"]
    # A job that is killed is interrupted, and the same button goes on with it.
    (tmp_path / "home" / "finish").unlink()
    assert ask("POST", "p/home/run", {})[0] == 200
    state_when(ask, "running")
    pid = json.loads((tmp_path / "home" / "run.json").read_text())["pid"]
    subprocess.run(["kill", "-9", str(pid)], check=True)
    assert [s["state"] for s in state_when(ask, "interrupted")["stages"]] == ["waiting"]
    assert ask("GET", "p/home/state")[1] == found
    (tmp_path / "home" / "finish").touch()
    assert ask("POST", "p/home/run", {})[0] == 200
    state_when(ask, "done")
