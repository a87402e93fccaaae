"""Work on the items of a stage on several cores, in worker processes."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from typing import Any, TypeVar

import cv2
from threadpoolctl import threadpool_limits

Item = TypeVar("Item")
Result = TypeVar("Result")

#: In a worker process: the function that it calls, and all items.
_function: Callable[[Any], Any]
_items: Sequence[Any]


def each(
    function: Callable[[Item], Result], items: Iterable[Item], workers: int
) -> Iterator[Result]:
    """Yield a function's result for each item, in order; `workers` items are worked on at a time.

    Many small numpy calls hold Python's lock, so threads hardly speed them up. The workers are
    forked from this process and share its memory, so no item is sent to them; their results and
    errors are pickled. Meanwhile numeric libraries use one thread. Where forking is not safe (not
    on Linux, or this process has threads), threads are used instead. The results do not depend on
    `workers`.
    """
    given = list(items)
    count = min(workers, len(given))
    if count < 2:
        yield from map(function, given)
        return
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)  # ends OpenCV's threads, which forked workers would miss
    try:
        with threadpool_limits(1):
            if sys.platform == "linux" and threading.active_count() == 1:
                yield from _forked(function, given, count)
            else:
                with ThreadPoolExecutor(count) as pool:
                    yield from pool.map(function, given)
    finally:
        cv2.setNumThreads(threads)


def _forked(
    function: Callable[[Item], Result], items: Sequence[Item], count: int
) -> Iterator[Result]:
    """Yield the results of forked workers, in order."""
    fork = multiprocessing.get_context("fork")
    with ProcessPoolExecutor(count, fork, _begin, (function, items)) as pool:
        try:
            yield from pool.map(_result, range(len(items)))
        finally:
            pool.shutdown(cancel_futures=True)


def _begin(function: Callable[[Any], Any], items: Sequence[Any]) -> None:
    """Make this process a worker; it ends when its parent ends, even if the parent is killed."""
    global _function, _items
    threading.Thread(target=_end_with_parent, daemon=True).start()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent handles Control-C
    _function, _items = function, items


def _end_with_parent() -> None:
    """Wait until the parent ends, and end this worker then."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
    os._exit(1)


def _result(index: int) -> Any:
    """Return the result of an item, in a worker."""
    return _function(_items[index])
