"""Check that Snakemake can see when jobs end on this SLURM cluster.

Snakemake gets the status of jobs from ``squeue``, which forgets a finished job after MinJobAge
seconds, or from ``sacct``, which knows no job if accounting is off. It would wait for ever for a
job whose end it does not see, so this is checked before the first submission.
"""

from __future__ import annotations

import re
import subprocess

from plan2scene.errors import InputError

#: Longest time between two queries of the job status, plus the time of the queries, in seconds.
LONGEST_PAUSE = 180 + 20


def read_settings(text: str) -> dict[str, str]:
    """Return the settings that ``scontrol show config`` prints, by name."""
    pairs = (line.partition("=") for line in text.splitlines() if "=" in line)
    return {name.strip(): value.strip() for name, _, value in pairs}


def check_status(settings: dict[str, str], command: str) -> None:
    """Raise InputError if `command` (squeue or sacct) would miss the end of a job."""
    accounting = settings.get("AccountingStorageType", "").rpartition("/")[2] not in ("", "none")
    min_job_age = re.match(r"\d+", settings.get("MinJobAge", ""))
    if command == "sacct" and not accounting:
        raise InputError(
            "--slurm-status-command squeue", "sacct, and accounting is off", file="SLURM"
        )
    if command == "squeue" and min_job_age and int(min_job_age.group()) < LONGEST_PAUSE:
        found = f"MinJobAge={min_job_age.group()}: squeue forgets jobs before their end is seen"
        other = "--slurm-status-command sacct" if accounting else "accounting or a longer memory"
        raise InputError(other, found, file="SLURM")


def check_cluster(command: str) -> None:
    """Raise InputError if no SLURM answers, or if `command` would not see the end of its jobs."""
    try:
        shown = subprocess.run(
            ["scontrol", "show", "config"], capture_output=True, text=True, timeout=60, check=False
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise InputError(
            "a login node of a SLURM cluster", f"scontrol: {error}", file="SLURM"
        ) from None
    if shown.returncode != 0:
        lines = shown.stderr.strip().splitlines() or ["no answer"]
        raise InputError("a login node of a SLURM cluster", lines[-1], file="SLURM")
    check_status(read_settings(shown.stdout), command)
