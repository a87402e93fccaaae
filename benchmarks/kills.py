"""Kills at random moments: ``python benchmarks/kills.py --kills 50 --rounds 5``.

Each round kills ``plan2scene run`` on the example plan and ``snakemake all`` on a house of the
demo, the whole process group by SIGKILL, starts each by the same words until it is done and
compares every file with an undisturbed run's.
"""

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

CLONE = Path(__file__).parents[1]
sys.path.insert(0, str(CLONE / "tests" / "workflow"))

from clones import demo_rows, make_clone  # noqa: E402
from kills import digests, finished, house_command, kill_often, strays  # noqa: E402

HEAD = "| command | kills | undisturbed, s | files that differ | stray temporary files |"
#: What changes from run to run: pages and tables name no time, so only logs and records do.
OTHER = ("work",)


def run_rounds(base: Path, kills: int, rounds: int) -> str:
    """Return the row of ``plan2scene run``."""
    plan = CLONE / "resources" / "examples" / "plan.json"
    began = time.perf_counter()
    finished(house_command(plan, base / "whole"))
    whole_s = time.perf_counter() - began
    hit = differ = left = 0
    for k in range(rounds):
        out = base / f"run_{k}"
        hit += kill_often(house_command(plan, out), kills // rounds, whole_s, seed=k)
        expected, found = digests(base / "whole", OTHER), digests(out, OTHER)
        names = {*expected, *found}
        differ += sum(expected.get(name) != found.get(name) for name in names)
        left += len(strays(out))
    return f"| `plan2scene run` | {hit} | {whole_s:.0f} | {differ} | {left} |"


def all_rounds(base: Path, kills: int, rounds: int) -> str:
    """Return the row of ``snakemake all``: users are told to unlock after a kill."""
    command = [sys.executable, "-m", "snakemake", "--cores", "1", "all"]
    unlock = [*command[:3], "--unlock"]
    seconds, found = 0.0, []
    hit = 0
    for k in range(rounds + 1):
        root = make_clone(base / f"all_{k}", demo_rows()[:1]).root
        began = time.perf_counter()
        for j in range(kills // rounds if k else 0):
            hit += kill_often_once(command, unlock, root, seconds, seed=1000 * k + j)
        subprocess.run(unlock, cwd=root, check=False, capture_output=True)
        finished(command, cwd=root)
        seconds = seconds or time.perf_counter() - began
        found.append((digests(root / "results"), len(strays(root / "results"))))
    expected = found[0][0]
    differ = sum(
        expected.get(name) != made.get(name) for made, _ in found for name in {*expected, *made}
    )
    left = sum(number for _, number in found)
    return f"| `snakemake all` | {hit} | {seconds:.0f} | {differ} | {left} |"


def kill_often_once(
    command: list[str], unlock: list[str], root: Path, longest_s: float, seed: int
) -> int:
    """Unlock, start and kill once; return 1 where the kill hit."""
    import random

    from kills import killed

    subprocess.run(unlock, cwd=root, check=False, capture_output=True)
    return int(killed(command, random.Random(seed).uniform(0, longest_s), cwd=root))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=100, help="of each command")
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="kills_") as folder:
        print(HEAD, "|---" * 5 + "|", sep="\n")
        print(run_rounds(Path(folder), options.kills, options.rounds), flush=True)
        print(all_rounds(Path(folder), options.kills, options.rounds), flush=True)


if __name__ == "__main__":
    main()
