"""Kill the commands at random moments: ``python benchmarks/kills.py --kills 100``.

The commands are ``plan2scene run`` on the example plan, and ``snakemake all`` on a house of the
demo with two texture methods. In each round a command is started again and killed until it
finishes; then every file is compared with that of an undisturbed run. SIGKILL goes to the whole
process group; every other time, for ``run``, its process alone gets SIGTERM, SIGINT, SIGHUP or
SIGKILL in turn. Processes that are left after 10 s are counted. A row sums up all rounds so far.
Kills fall within half the time of an undisturbed run; finished steps stay done, so kills meet every
stage.
"""

import argparse
import random
import signal
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
from kills import digests, finished, house_command, killed, orphans, strays  # noqa: E402

HEAD = (
    "| command | rounds | kills | undisturbed, s | files that differ | stray temporary files "
    "| orphans | refused |"
)
#: Signals that go to a single process, in turn.
ALONE = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGKILL)
#: Files that differ between runs: only logs and records, because pages and tables have no time.
OTHER = ("work",)
#: Methods of the table; with these two a round takes one minute instead of four.
METHODS = ["crop", "exemplar"]


@dataclass
class Seen:
    """The counts for a command over all rounds so far."""

    command: str
    undisturbed_s: float
    kills: int = 0
    rounds: int = 0
    differ: int = 0
    strays: int = 0
    orphans: int = 0
    refused: int = 0

    def add(self, hit: int, whole: dict[str, str], made: Path, but: tuple[str, ...] = ()) -> None:
        """Count a round: kills that hit, and files that differ from those of an undisturbed run."""
        found = digests(made, but)
        self.kills += hit
        self.rounds += 1
        self.differ += sum(whole.get(name) != found.get(name) for name in {*whole, *found})
        self.strays += len(strays(made))

    def row(self) -> str:
        """Return the row of the table."""
        cells = [f"`{self.command}`", self.rounds, self.kills, f"{self.undisturbed_s:.0f}"]
        cells += [self.differ, self.strays, self.orphans, self.refused]
        return f"| {' | '.join(map(str, cells))} |"


def run_rounds(base: Path, kills: int) -> Iterator[str]:
    """Yield a row for ``plan2scene run`` after each round, until there were `kills` kills."""
    plan = CLONE / "resources" / "examples" / "plan.json"
    began = time.perf_counter()
    finished(house_command(plan, base / "whole"))
    seen = Seen("plan2scene run", time.perf_counter() - began)
    whole = digests(base / "whole", OTHER)
    while seen.kills < kills:
        out = base / f"run_{seen.rounds}"
        command = house_command(plan, out)
        hit = kills_of_a_round(command, seen, base, alone=True)
        try:
            finished(command)
        except AssertionError as error:
            seen.refused += 1
            print(error, file=sys.stderr)
        seen.add(hit, whole, out, OTHER)
        yield seen.row()


def all_rounds(base: Path, kills: int) -> Iterator[str]:
    """Yield a row for ``snakemake all`` after each round; like users, it unlocks after a kill."""
    command = [sys.executable, "-m", "snakemake", "--cores", "1", "all"]
    unlock = [*command[:3], "--unlock"]
    seen = Seen("snakemake all", 0.0)
    root = make_clone(base / "whole_all", demo_rows()[:1], methods=METHODS).root
    began = time.perf_counter()
    finished(command, cwd=root)
    seen.undisturbed_s = time.perf_counter() - began
    whole = digests(root / "results")
    while seen.kills < kills:
        root = make_clone(base / f"all_{seen.rounds}", demo_rows()[:1], methods=METHODS).root
        hit = kills_of_a_round(command, seen, root, unlock)
        finished(command, cwd=root)
        seen.add(hit, whole, root / "results")
        yield seen.row()


def kills_of_a_round(
    command: list[str],
    seen: Seen,
    folder: Path,
    unlock: list[str] | None = None,
    *,
    alone: bool = False,
) -> int:
    """Kill a command again and again until it ends before its kill; return how many kills hit."""
    chance, hit = random.Random(seen.rounds), 0
    while True:
        sent = ALONE[(hit // 2) % len(ALONE)] if alone and hit % 2 == 0 else None
        if not killed(command, chance.uniform(0, seen.undisturbed_s / 2), sent, cwd=folder):
            break
        hit += 1
        if hit % 3 == 0:  # every third time, wait and count what is left
            seen.orphans += orphans(folder)
        if unlock:
            subprocess.run(unlock, cwd=folder, check=False, capture_output=True)
    return hit


COMMANDS = {"run": run_rounds, "all": all_rounds}


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=100, help="of each command")
    parser.add_argument("--only", choices=list(COMMANDS), help="one of the two commands")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="kills_") as folder:
        print(HEAD, "|---" * 8 + "|", sep="\n")
        for name in [options.only] if options.only else COMMANDS:
            for row in COMMANDS[name](Path(folder), options.kills):
                print(row, flush=True)


if __name__ == "__main__":
    main()
