"""Kills at random moments: ``python benchmarks/kills.py --kills 100 --rounds 10``.

Each round kills ``plan2scene run`` on the example plan and ``snakemake all`` on a house of the
demo by two methods, the whole process group by SIGKILL, starts each by the same words until it is
done and compares every file with an undisturbed run's. A row is all rounds until then.
"""

import argparse
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

CLONE = Path(__file__).parents[1]
sys.path.insert(0, str(CLONE / "tests" / "workflow"))

from clones import demo_rows, make_clone  # noqa: E402
from kills import digests, finished, house_command, kill_often, killed, strays  # noqa: E402

HEAD = "| command | kills | undisturbed, s | files that differ | stray temporary files |"
#: What changes from run to run: pages and tables name no time, so only logs and records do.
OTHER = ("work",)
#: Of the table, so that a round takes a minute and not four.
METHODS = ["crop", "exemplar"]


@dataclass
class Seen:
    """What became of a command in all rounds until now."""

    command: str
    undisturbed_s: float
    kills: int = 0
    differ: int = 0
    strays: int = 0

    def add(self, hit: int, whole: dict[str, str], made: Path, but: tuple[str, ...] = ()) -> None:
        """Count a round: kills that hit, files that are not those of an undisturbed run."""
        found = digests(made, but)
        self.kills += hit
        self.differ += sum(whole.get(name) != found.get(name) for name in {*whole, *found})
        self.strays += len(strays(made))

    def row(self) -> str:
        """Return the row of the table."""
        cells = [f"`{self.command}`", self.kills, f"{self.undisturbed_s:.0f}"]
        return f"| {' | '.join(map(str, [*cells, self.differ, self.strays]))} |"


def run_rounds(base: Path, kills: int, rounds: int) -> Iterator[str]:
    """Yield a row of ``plan2scene run`` after each round."""
    plan = CLONE / "resources" / "examples" / "plan.json"
    began = time.perf_counter()
    finished(house_command(plan, base / "whole"))
    seen = Seen("plan2scene run", time.perf_counter() - began)
    whole = digests(base / "whole", OTHER)
    for k in range(rounds):
        out = base / f"run_{k}"
        hit = kill_often(house_command(plan, out), kills // rounds, seen.undisturbed_s, seed=k)
        seen.add(hit, whole, out, OTHER)
        yield seen.row()


def all_rounds(base: Path, kills: int, rounds: int) -> Iterator[str]:
    """Yield a row of ``snakemake all`` after each round: users are told to unlock after a kill."""
    command = [sys.executable, "-m", "snakemake", "--cores", "1", "all"]
    unlock = [*command[:3], "--unlock"]
    seen = Seen("snakemake all", 0.0)
    whole: dict[str, str] = {}
    for k in range(rounds + 1):
        root = make_clone(base / f"all_{k}", demo_rows()[:1], methods=METHODS).root
        began = time.perf_counter()
        hit = sum(
            kill_often_once(command, unlock, root, seen.undisturbed_s, seed=1000 * k + j)
            for j in range(kills // rounds if k else 0)
        )
        subprocess.run(unlock, cwd=root, check=False, capture_output=True)
        finished(command, cwd=root)
        if k == 0:
            seen.undisturbed_s = time.perf_counter() - began
            whole = digests(root / "results")
        else:
            seen.add(hit, whole, root / "results")
            yield seen.row()


def kill_often_once(
    command: list[str], unlock: list[str], root: Path, longest_s: float, seed: int
) -> int:
    """Unlock, start and kill once; return 1 where the kill hit."""
    subprocess.run(unlock, cwd=root, check=False, capture_output=True)
    return int(killed(command, random.Random(seed).uniform(0, longest_s), cwd=root))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=100, help="of each command")
    parser.add_argument("--rounds", type=int, default=10)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="kills_") as folder:
        print(HEAD, "|---" * 5 + "|", sep="\n")
        for rounds in (run_rounds, all_rounds):
            for row in rounds(Path(folder), options.kills, options.rounds):
                print(row, flush=True)


if __name__ == "__main__":
    main()
