"""A SLURM of this machine alone, on loopback, in a temporary folder.

munged, slurmctld and a slurmd for each node are started and taken down again. Wants root and the
programs of Debian's slurm-wlm; nothing outside the folder is touched.
"""

import os
import secrets
import shutil
import socket
import subprocess
import tempfile
import time
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "srun", "squeue", "scontrol", "setpriv")
#: How long the daemons may take to answer, in seconds.
PATIENCE = 60
CONF = """\
ClusterName=loopback
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={port}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
SlurmUser=root
SlurmdUser=root
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/%n.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SwitchType=switch/none
ReturnToService=2
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
JobAcctGatherType=jobacct_gather/linux
JobAcctGatherFrequency=task=1
JobAcctGatherParams=OverMemoryKill
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/filetxt
JobCompLoc={folder}/finished.txt
SlurmdParameters=config_overrides
SlurmdTimeout=5
KillWait=2
MinJobAge={min_job_age}
PartitionName=main Nodes=ALL Default=YES State=UP
PartitionName=other Nodes=ALL State=UP
"""
NODE = (
    "NodeName={name} NodeHostname={host} NodeAddr=127.0.0.1 Port={port} CPUs={cpus} "
    "RealMemory={memory}\n"
)


def missing():
    """Return in a line why no SLURM can be started here; nothing where one can."""
    if os.geteuid() != 0:
        return "a SLURM on loopback wants root"
    absent = [name for name in PROGRAMS if shutil.which(name) is None]
    return f"not installed (Debian: slurm-wlm): {', '.join(absent)}" if absent else ""


def free_ports(count):
    with ExitStack() as opened:
        sockets = [opened.enter_context(socket.socket()) for _ in range(count)]
        for each in sockets:
            each.bind(("127.0.0.1", 0))
        return [each.getsockname()[1] for each in sockets]


@dataclass
class Cluster:
    """A running SLURM: what it takes to use it and to harm it."""

    folder: Path
    daemons: dict[str, subprocess.Popen[bytes]] = field(default_factory=dict)

    @property
    def environment(self):
        """Return the environment of its users: which SLURM, and programs that keep to it.

        Job steps start without SLURM's variables, so ``srun`` is told by a script of that name.
        """
        path = f"{self.folder / 'bin'}:{os.environ['PATH']}"
        clean = {k: v for k, v in os.environ.items() if not k.startswith(("SLURM_", "SBATCH_"))}
        return clean | {"SLURM_CONF": str(self.folder / "slurm.conf"), "PATH": path}

    def start(self, name, *command):
        """Start a daemon that ends with this process, in the foreground, its output in a log."""
        words = ("setpriv", "--pdeathsig", "TERM", *command)
        with (self.folder / f"{name}.log").open("ab") as log:
            self.daemons[name] = subprocess.Popen(
                words, env=self.environment, stdout=log, stderr=log, start_new_session=True
            )

    def start_node(self, name):
        self.start(name, "slurmd", "-D", "-N", name)

    def ask(self, *command):
        done = subprocess.run(
            command, env=self.environment, capture_output=True, text=True, check=False
        )
        return done.stdout if done.returncode == 0 else ""

    def wait_for(self, what, *command):
        """Wait until `what` is in the answer of a command."""
        end = time.monotonic() + PATIENCE
        while what not in self.ask(*command):
            if time.monotonic() > end:
                logs = {p.name: p.read_text()[-500:] for p in self.folder.glob("*.log")}
                raise TimeoutError(f"{' '.join(command)} never said {what!r}: {logs}")
            time.sleep(0.1)

    def finished(self):
        """Return what SLURM notes of each job that ended: JobId, JobState, StartTime, EndTime."""
        path = self.folder / "finished.txt"
        lines = path.read_text().splitlines() if path.exists() else []
        return [dict(word.split("=", 1) for word in line.split() if "=" in word) for line in lines]

    def stop(self):
        end = time.monotonic() + 10
        while self.ask("squeue", "--noheader") and time.monotonic() < end:
            self.ask("scancel", "--quiet", "--user", "root")
            time.sleep(0.2)
        for name in reversed(list(self.daemons)):
            self.daemons[name].terminate()
        for daemon in self.daemons.values():
            try:
                daemon.wait(10)
            except subprocess.TimeoutExpired:
                daemon.kill()


def write_settings(folder, cpus, memory, min_job_age):
    """Write key, configuration and the script `srun` of a cluster."""
    host, (port, own) = socket.gethostname(), free_ports(2)
    node = NODE.format(name="node0", host=host, port=own, cpus=cpus, memory=memory)
    head = CONF.format(host=host, port=port, folder=folder, min_job_age=min_job_age)
    (folder / "slurm.conf").write_text(node + head)
    for name in ("state", "bin", "node0"):
        (folder / name).mkdir()
    key = folder / "munge.key"
    key.write_bytes(secrets.token_bytes(1024))
    key.chmod(0o400)
    script = folder / "bin" / "srun"
    script.write_text(
        f'#!/bin/sh\nSLURM_CONF={folder}/slurm.conf exec {shutil.which("srun")} "$@"\n'
    )
    script.chmod(0o755)


@contextmanager
def cluster(*, cpus=8, memory=16000, min_job_age=300):
    """Run a SLURM without accounting; a node claims to have `cpus` and `memory` (MB)."""
    with tempfile.TemporaryDirectory(prefix="slurm_", ignore_cleanup_errors=True) as name:
        folder = Path(name)
        folder.chmod(0o755)
        write_settings(folder, cpus, memory, min_job_age)
        made = Cluster(folder)
        files = {"key-file": "munge.key", "socket": "munge.socket", "pid-file": "munged.pid"}
        files |= {"log-file": "munged.log", "seed-file": "munge.seed"}
        options = [f"--{option}={folder / file}" for option, file in files.items()]
        try:
            made.start("munge", "munged", "--force", "--foreground", *options)
            made.wait_for("MUNGE:", "munge", "-n", "--socket", str(folder / "munge.socket"))
            made.start("slurmctld", "slurmctld", "-D", "-c")
            made.start_node("node0")
            made.wait_for("idle", "sinfo", "--noheader", "-o", "%T", "-n", "node0")
            yield made
        finally:
            made.stop()
