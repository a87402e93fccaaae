import subprocess
import sys
from pathlib import Path

PROFILE = Path(__file__).parents[2] / "workflow" / "profiles" / "slurm"
#: One file system, and jobs of seconds: looks at them soon, and waits for no NFS.
QUICK = ("--slurm-init-seconds-before-status-checks", "5", "--latency-wait", "5")


def submit(slurm, folder, *arguments, **further):
    """Run Snakemake in a folder with the profile; `further` are environment variables."""
    return subprocess.run(
        [sys.executable, "-m", "snakemake", "--profile", str(PROFILE), *QUICK, *arguments],
        cwd=folder,
        env=slurm.environment | {"OMP_NUM_THREADS": "1"} | further,
        text=True,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        timeout=1500,
        check=False,
    )
