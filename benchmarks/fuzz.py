"""Fuzzing of every reader of foreign bytes: ``python benchmarks/fuzz.py --cases 20000``.

Hypothesis damages whole files of each kind (tests/helpers/foreign.py): every registered plan
format, tables, pictures, weights, configuration, what the workflow keeps. A case may be read or
refused in one line within 20 s and 1.5 GB; anything else, silent nonsense too, is kept in
``--found`` under the reader's name and fails the command. One line for an exception that a reader
did not foresee is counted by itself and kept.
"""

import argparse
import hashlib
import logging
import resource
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

CLONE = Path(__file__).parents[1]
sys.path.insert(0, str(CLONE / "tests" / "helpers"))

from foreign import READERS, Reader, foreign_bytes, outcome  # noqa: E402
from hypothesis import HealthCheck, Phase, given, seed, settings  # noqa: E402

HEAD = "| reader | cases | read | one line | unforeseen | other | slowest, s | peak memory, MiB |"
OUTCOMES = ("read", "one line", "unforeseen", "other")
#: Most seconds and bytes of a case.
SECONDS, BYTES = 20, 1_500_000_000


def fuzz(reader: Reader, cases: int, start: int, found: Path) -> tuple[Counter[str], float]:
    """Return outcomes of one reader and its slowest case in seconds."""
    seen: Counter[str] = Counter()
    slowest = [0.0]
    folder = Path(tempfile.mkdtemp(prefix="fuzz_"))

    @seed(start)
    @settings(
        max_examples=cases,
        deadline=None,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(foreign_bytes(reader))
    def check(data: bytes) -> None:
        inside = folder / "inside"
        shutil.rmtree(inside, ignore_errors=True)
        inside.mkdir()
        began = time.perf_counter()
        try:
            signal.alarm(SECONDS)
            seen[result := outcome(reader, data, inside)] += 1
            if result == "unforeseen":
                keep(reader, data, found)
            if [path.name for path in folder.iterdir()] != ["inside"]:
                raise RuntimeError("written outside its folder")
        except (Exception, SlowCase) as error:  # noqa: BLE001
            seen["other"] += 1
            kept = keep(reader, data, found)
            print(f"{reader.name}: {type(error).__name__}: {error} ({kept})", file=sys.stderr)
        signal.alarm(0)
        slowest[0] = max(slowest[0], time.perf_counter() - began)

    check()
    shutil.rmtree(folder)
    return seen, slowest[0]


def keep(reader: Reader, data: bytes, found: Path) -> Path:
    """Write a case to look at."""
    kept = found / reader.name / hashlib.sha256(data).hexdigest()[:12]
    kept.parent.mkdir(parents=True, exist_ok=True)
    kept.write_bytes(data)
    return kept


def too_long(*_: object) -> None:
    """End a case, not as a fault that its reader could turn into a line."""
    raise SlowCase


class SlowCase(BaseException):
    """A case takes longer than it may."""


def main() -> None:
    """Print the table; exit code 1 where anything but a house or one line came out."""
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
        whole = reader.examples()
        ready = Reader(reader.name, lambda whole=whole: whole, reader.read)
        seen, slowest = fuzz(ready, each, options.seed, options.found)
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        cells = [seen.total(), *(seen[key] for key in OUTCOMES)]
        print(f"| {reader.name} | {' | '.join(map(str, cells))} | {slowest:.2f} | {peak:.0f} |")
        others += seen["other"]
    sys.exit(1 if others else 0)


if __name__ == "__main__":
    main()
