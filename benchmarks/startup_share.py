"""What share of a run's job time is the start of processes: interpreter and imports.

    python benchmarks/startup_share.py snakemake -j2 --forceall --configfile config/benchmark.yaml
        -- results/benchmark/tables/paper_table.csv

Runs the command with a hook in every Python process of it that times the outermost imports, lazy
ones included, and prints for each script: jobs, seconds from the start of the process to its end,
and how much of that was start-up. Snakemake's own process is listed apart. Linux only (/proc).
"""

from __future__ import annotations

import collections
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

#: Read by every interpreter as it starts.
HOOK = '''
import atexit, builtins, json, os, sys, threading, time

def _since_start():
    """Seconds since this process was made."""
    with open("/proc/self/stat") as file:
        ticks = int(file.read().rsplit(")", 1)[1].split()[19])
    with open("/proc/uptime") as file:
        now = float(file.read().split()[0])
    return now - ticks / os.sysconf("SC_CLK_TCK")

_begun = _since_start()
_clock = time.perf_counter()
_state = threading.local()
_total = [0.0]
_import = builtins.__import__

def _timed(*args, **kwargs):
    if getattr(_state, "inside", False):
        return _import(*args, **kwargs)
    _state.inside = True
    start = time.perf_counter()
    try:
        return _import(*args, **kwargs)
    finally:
        _total[0] += time.perf_counter() - start
        _state.inside = False

def _report():
    lived = _begun + time.perf_counter() - _clock
    row = {"script": sys.argv[0], "lived": lived, "interpreter": _begun, "imports": _total[0]}
    name = "%d-%d.json" % (os.getpid(), time.time_ns())  # process numbers come again
    path = os.path.join(os.environ["STARTUP_SHARE"], name)
    with open(path, "w") as file:
        json.dump(row, file)

builtins.__import__ = _timed
atexit.register(_report)
'''


def main() -> int:
    command = sys.argv[1:]
    if not command:
        print(__doc__)
        return 2
    with tempfile.TemporaryDirectory() as name:
        hook, reports = Path(name) / "hook", Path(name) / "reports"
        hook.mkdir()
        reports.mkdir()
        (hook / "sitecustomize.py").write_text(HOOK)
        path = os.pathsep.join(filter(None, [str(hook), os.environ.get("PYTHONPATH")]))
        environment = os.environ | {"PYTHONPATH": path, "STARTUP_SHARE": str(reports)}
        start = time.perf_counter()
        code = subprocess.run(command, env=environment, check=False).returncode
        wall = time.perf_counter() - start
        rows = [json.loads(file.read_text()) for file in reports.iterdir()]
    jobs = collections.defaultdict(list)
    others = []
    for row in rows:
        # Snakemake copies a script to .snakemake/scripts/tmp{random}.{name}.py
        job = re.fullmatch(r"tmp\w+\.(\w+)\.py", Path(row["script"]).name)
        (jobs[job[1]] if job else others).append(row)
    print(f"\ncommand: {wall:.0f} s, exit code {code}")
    print("| job | count | seconds | start-up | share |\n|---|---|---|---|---|")
    for script, members in sorted(jobs.items()):
        line(script, members)
    line("all jobs", [row for members in jobs.values() for row in members])
    for row in others:
        print(f"not a job: {Path(row['script']).name}, {row['lived']:.0f} s")
    return code


def line(name: str, rows: list[dict[str, float]]) -> None:
    lived = sum(row["lived"] for row in rows)
    start_up = sum(row["interpreter"] + row["imports"] for row in rows)
    share = 100 * start_up / lived if lived else 0.0
    print(f"| {name} | {len(rows)} | {lived:.0f} | {start_up:.0f} | {share:.0f} % |")


if __name__ == "__main__":
    raise SystemExit(main())
