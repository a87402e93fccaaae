"""Fuzzing of every reader of foreign bytes: ``python benchmarks/fuzz.py --cases 20000``.

Hypothesis damages whole files of each kind (tests/helpers/foreign.py). A case may be read or
refused in one line; anything else is kept in ``--found`` under the reader's name and fails the
command.
"""

import argparse
import hashlib
import resource
import shutil
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

CLONE = Path(__file__).parents[1]
sys.path.insert(0, str(CLONE / "tests" / "helpers"))

from foreign import READERS, Reader, foreign_bytes, outcome  # noqa: E402
from hypothesis import HealthCheck, Phase, given, seed, settings  # noqa: E402

HEAD = "| reader | cases | read | one line | other | slowest, s | peak memory, MiB |"


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
            seen[outcome(reader, data, inside)] += 1
            if [path.name for path in folder.iterdir()] != ["inside"]:
                raise RuntimeError("written outside its folder")
        except Exception as error:  # noqa: BLE001
            seen["other"] += 1
            kept = found / reader.name / hashlib.sha256(data).hexdigest()[:12]
            kept.parent.mkdir(parents=True, exist_ok=True)
            kept.write_bytes(data)
            print(f"{reader.name}: {type(error).__name__}: {error} ({kept})", file=sys.stderr)
        slowest[0] = max(slowest[0], time.perf_counter() - began)

    check()
    shutil.rmtree(folder)
    return seen, slowest[0]


def main() -> None:
    """Print the table; exit code 1 where anything but a house or one line came out."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=20_000, help="of all readers together")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--found", type=Path, default=Path("results/fuzz"))
    options = parser.parse_args()
    each = -(-options.cases // len(READERS))
    print(HEAD, "|---" * 7 + "|", sep="\n")
    others = 0
    for reader in READERS:
        whole = reader.examples()
        ready = Reader(reader.name, lambda whole=whole: whole, reader.read)
        seen, slowest = fuzz(ready, each, options.seed, options.found)
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        cells = [sum(seen.values()), seen["read"], seen["one line"], seen["other"]]
        print(f"| {reader.name} | {' | '.join(map(str, cells))} | {slowest:.2f} | {peak:.0f} |")
        others += seen["other"]
    sys.exit(1 if others else 0)


if __name__ == "__main__":
    main()
