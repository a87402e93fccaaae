"""Commands that are killed at random moments and started again by the same words."""

import hashlib
import os
import random
import signal
import subprocess
import sys
import time

import psutil


def house_command(plan, out, *further):
    program = [sys.executable, "-c", "from plan2scene_app.cli import main; main()"]
    return [*program, "run", "--plan", str(plan), "--out", str(out), "--cores", "1", *further]


def killed(command, after_s, alone=None, **options):
    """Start a command, kill its whole process group after some seconds; False if it was done.

    With `alone` the command's own process gets that signal, and no other one.
    """
    process = subprocess.Popen(
        command,
        start_new_session=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        **options,
    )
    try:
        process.wait(timeout=after_s)
    except subprocess.TimeoutExpired:
        if alone is None:
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.send_signal(alone)
        process.wait()
        return True
    return False


def finished(command, **options):
    run = subprocess.run(
        command, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, **options
    )
    if run.returncode:
        raise AssertionError(run.stdout[-3000:])
    return run.stdout


def orphans(folder, within_s=10.0):
    """Return how many processes that name a folder in their command line are left after a time."""
    until = time.monotonic() + within_s
    while True:
        left = 0
        for process in psutil.process_iter(["cmdline", "pid"]):
            words = process.info["cmdline"] or []
            left += process.pid != os.getpid() and any(str(folder) in word for word in words)
        if not left or time.monotonic() > until:
            return left
        time.sleep(0.2)


def kill_often(command, kills, longest_s, seed, **options):
    """Kill a command at random moments, then let it finish; return how many kills hit."""
    chance = random.Random(seed)
    hit = sum(killed(command, chance.uniform(0, longest_s), **options) for _ in range(kills))
    finished(command, **options)
    return hit


def digests(folder, but=()):
    """Return the hash of every file of a folder, without those below some of its folders."""
    found = {}
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder)
        if path.is_file() and name.parts[0] not in but:
            found[name.as_posix()] = hashlib.sha256(path.read_bytes()).hexdigest()
    return found


def strays(folder):
    return [path.name for path in folder.rglob(".tmp_*")]
