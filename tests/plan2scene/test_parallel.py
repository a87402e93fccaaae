import os
import signal
import subprocess
import sys
import threading
import time
from itertools import islice

import cv2
import psutil
import pytest

from plan2scene.errors import InputError
from plan2scene.parallel import each

linux = pytest.mark.skipif(sys.platform != "linux", reason="workers are forked on Linux alone")


@pytest.mark.parametrize("workers", [1, 2, 5])
@pytest.mark.parametrize("count", [0, 1, 7])
def test_results_come_in_order_whatever_the_workers(workers, count):
    factor = 3  # known to the workers, though nothing is sent to them
    assert list(each(lambda k: factor * k, range(count), workers)) == list(range(0, 3 * count, 3))


@linux
def test_items_are_worked_on_in_other_processes():
    program = (  # another process: beside threads that tests left here nothing is forked
        "import os; from plan2scene.parallel import each\n"
        "pids = set(each(lambda _: os.getpid(), range(12), 3))\n"
        "assert os.getpid() not in pids and 1 <= len(pids) <= 3\n"
        "assert set(each(lambda _: os.getpid(), range(2), 1)) == {os.getpid()}"
    )
    subprocess.run([sys.executable, "-c", program], check=True)


def test_a_process_with_threads_is_not_forked():
    done = threading.Event()
    waiting = threading.Thread(target=done.wait)
    waiting.start()
    try:
        assert set(each(lambda _: os.getpid(), range(4), 2)) == {os.getpid()}
    finally:
        done.set()
        waiting.join()


def test_a_fault_of_the_user_reaches_the_caller_as_it_was_raised():
    def work(k):
        if k == 2:
            raise InputError("a photo", "a poem", file="a.jpg", house="h")
        return k

    with pytest.raises(InputError) as raised:
        list(each(work, range(4), 2))
    error = raised.value
    assert str(error) == "file a.jpg, house h: expected a photo, found a poem"
    assert (error.expected, error.found) == ("a photo", "a poem")


@linux
def test_who_asks_for_no_more_leaves_no_worker():
    threads, others = cv2.getNumThreads(), set(psutil.Process().children())
    found = each(lambda k: k, range(100), 2)
    assert list(islice(found, 3)) == [0, 1, 2]
    found.close()
    assert set(psutil.Process().children()) <= others  # of other tests here
    assert cv2.getNumThreads() == threads


@linux
def test_workers_end_when_their_parent_is_killed():
    program = (
        "import os, time; from plan2scene.parallel import each\n"
        "def work(k): os.write(1, b'%d\\n' % os.getpid()); time.sleep(60)\n"
        "list(each(work, range(2), 2))"
    )
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE) as parent:
        workers = [psutil.Process(int(parent.stdout.readline())) for _ in range(2)]
        assert all(worker.ppid() == parent.pid for worker in workers)
        os.kill(parent.pid, signal.SIGKILL)
        until = time.monotonic() + 10
        while any(worker.is_running() for worker in workers) and time.monotonic() < until:
            time.sleep(0.05)
        assert not any(worker.is_running() for worker in workers)
