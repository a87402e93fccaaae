"""How far a run is, read from what Snakemake tells."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field

#: What people call the rules, in the order of the work.
STAGES = {
    "floorplan": "Plan",
    "masks": "What the photos show",
    "crops": "Crops of floors, walls and ceilings",
    "embeddings": "What each crop looks like",
    "surfaces": "A crop for each surface",
    "materials": "Surfaces of one material",
    "propagated": "Surfaces that no photo shows",
    "textures": "Textures",
    "house": "The house in 3D",
}
_STATS = re.compile(r"^(\w+) +(\d+)\s*$")
_STARTED = re.compile(r"^(?:local)?(?:rule|checkpoint) (\w+):")
_FINISHED = re.compile(r"^Finished jobid: \d+ \(Rule: (\w+)\)")
_FAILED = re.compile(r"^Error in (?:rule|checkpoint) (\w+):")
_LINE = re.compile(r"^(?:ERROR|plan2scene:) (.*)")
_WARNING = re.compile(r"^WARNING (.*)")


@dataclass
class Progress:
    """Stages of a run: how many jobs each has, which are under way, done, failed."""

    planned: dict[str, int] = field(default_factory=dict)
    started: list[str] = field(default_factory=list)
    finished: list[str] = field(default_factory=list)
    failed: list[str] = field(default_factory=list)
    fault: str = ""
    warnings: list[str] = field(default_factory=list)

    def stages(self) -> list[dict[str, object]]:
        """Return ``{rule, title, state}`` of every stage of this run, in order."""
        order = list(STAGES)
        rules = sorted(self.planned, key=lambda r: order.index(r) if r in order else len(order))
        found: list[dict[str, object]] = []
        for rule in rules:
            if rule in self.failed:
                state = "failed"
            elif self.finished.count(rule) >= self.planned[rule]:
                state = "done"
            else:
                state = "running" if rule in self.started else "waiting"
            title = STAGES.get(rule, rule.replace("_", " ").capitalize())
            found.append({"rule": rule, "title": title, "state": state})
        return found


def read_progress(lines: Iterable[str]) -> Progress:
    """Return the progress that the lines of a run's log tell."""
    progress, in_stats = Progress(), False
    for line in lines:
        if line.startswith("Job stats:"):
            in_stats = True
            progress.planned.clear()
        elif in_stats and (found := _STATS.match(line)):
            if found[1] == "total":
                in_stats = False
            else:
                progress.planned[found[1]] = int(found[2])
        elif found := _STARTED.match(line):
            progress.started.append(found[1])
        elif found := _FINISHED.match(line):
            progress.finished.append(found[1])
        elif found := _FAILED.match(line):
            progress.failed.append(found[1])
        elif found := _WARNING.match(line):
            progress.warnings += [found[1]] if found[1] not in progress.warnings else []
        elif (found := _LINE.match(line)) and not progress.fault:
            progress.fault = found[1]
    return progress
