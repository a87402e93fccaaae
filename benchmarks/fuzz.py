"""Fuzz every reader of input files: ``python benchmarks/fuzz.py --cases 20000``.

Hypothesis damages valid files of each kind (tests/helpers/foreign.py): every registered plan
format, tables, pictures, weights, configuration, files that the workflow stores. A reader must read
a case or refuse it with one line, within 20 s and 1.5 GB. Any other outcome, also silent nonsense
or a crash, is stored in ``--found`` under the reader's name, and the command fails. A refusal by an
exception that the reader did not expect ("unforeseen") is counted separately and stored, too.
"""

import argparse
import hashlib
import logging
import multiprocessing
import resource
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from multiprocessing.connection import Connection
from pathlib import Path

CLONE = Path(__file__).parents[1]
sys.path.insert(0, str(CLONE / "tests" / "helpers"))

from foreign import READERS, Reader, foreign_bytes, outcome  # noqa: E402
from hypothesis import HealthCheck, Phase, given, seed, settings  # noqa: E402

HEAD = "| reader | cases | read | one line | unforeseen | other | slowest, s | peak memory, MiB |"
OUTCOMES = ("read", "one line", "unforeseen", "other")
#: Limits of a case: seconds, and bytes of memory.
SECONDS, BYTES = 20, 1_500_000_000
PROCESSES = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)


def fuzz(reader: Reader, cases: int, start: int, found: Path) -> tuple[Counter[str], float, float]:
    """Return a reader's outcomes, seconds of its slowest case, peak memory of its process in MiB.

    After a crash a new process continues with the next seed.
    """
    context = multiprocessing.get_context("fork")
    seen: Counter[str] = Counter()
    slowest = peak = 0.0
    while (left := cases - seen.total()) > 0:
        folder = Path(tempfile.mkdtemp(prefix="fuzz_"))
        ours, theirs = context.Pipe(duplex=False)
        child = context.Process(target=work, args=(reader, left, start, found, folder, theirs))
        child.start()
        theirs.close()
        try:
            while True:
                result, seconds, memory = ours.recv()
                seen[result] += 1
                slowest, peak = max(slowest, seconds), max(peak, memory)
        except EOFError:
            child.join()
        if child.exitcode:
            seen["other"] += 1
            kept = keep(reader, (folder / "inside" / reader.name).read_bytes(), found)
            print(f"{reader.name}: crash, exit code {child.exitcode} ({kept})", file=sys.stderr)
            start += 1
        shutil.rmtree(folder)
    return seen, slowest, peak


def work(
    reader: Reader, cases: int, start: int, found: Path, folder: Path, pipe: Connection
) -> None:
    """Send the outcome and seconds of each case, and the peak memory so far in MiB."""
    whole = reader.examples()
    ready = Reader(reader.name, lambda: whole, reader.read)

    @seed(start)
    @settings(
        max_examples=cases,
        deadline=None,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(foreign_bytes(ready))
    def check(data: bytes) -> None:
        inside = folder / "inside"
        shutil.rmtree(inside, ignore_errors=True)
        inside.mkdir()
        began = time.perf_counter()
        try:
            signal.alarm(SECONDS)
            result = outcome(ready, data, inside)
            if result == "unforeseen":
                keep(reader, data, found)
            if [path.name for path in folder.iterdir()] != ["inside"]:
                raise RuntimeError("written outside its folder")
        except (Exception, SlowCase) as error:  # noqa: BLE001
            result = "other"
            kept = keep(reader, data, found)
            print(f"{reader.name}: {type(error).__name__}: {error} ({kept})", file=sys.stderr)
        signal.alarm(0)
        most = [resource.getrusage(who).ru_maxrss for who in PROCESSES]
        pipe.send((result, time.perf_counter() - began, max(most) / 1024))

    check()


def keep(reader: Reader, data: bytes, found: Path) -> Path:
    """Store a case for later inspection; return its path."""
    kept = found / reader.name / hashlib.sha256(data).hexdigest()[:12]
    kept.parent.mkdir(parents=True, exist_ok=True)
    kept.write_bytes(data)
    return kept


def too_long(*_: object) -> None:
    """End a case by an exception that its reader does not catch."""
    raise SlowCase


class SlowCase(BaseException):
    """A case takes longer than `SECONDS`."""


def main() -> None:
    """Print the table; exit with code 1 if there was any outcome "other"."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=20_000, help="of all readers together")
    parser.add_argument("--only", nargs="+", help="the readers of these names")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--found", type=Path, default=Path("results/fuzz"))
    options = parser.parse_args()
    signal.signal(signal.SIGALRM, too_long)
    resource.setrlimit(resource.RLIMIT_DATA, (BYTES, BYTES))
    logging.disable(logging.WARNING)
    chosen = [r for r in READERS if not options.only or r.name in options.only]
    each = -(-options.cases // len(chosen))
    print(HEAD, "|---" * 8 + "|", sep="\n")
    others = 0
    for reader in chosen:
        seen, slowest, peak = fuzz(reader, each, options.seed, options.found)
        cells = [seen.total(), *(seen[key] for key in OUTCOMES)]
        row = f"| {reader.name} | {' | '.join(map(str, cells))} | {slowest:.2f} | {peak:.0f} |"
        print(row, flush=True)
        others += seen["other"]
    sys.exit(1 if others else 0)


if __name__ == "__main__":
    main()
