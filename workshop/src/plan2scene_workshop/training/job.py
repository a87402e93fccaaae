"""The common frame of every training job's script: log, threads, seed and checkpoint."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import torch

from plan2scene_app.workflow.jobs import job


@contextmanager
def training_job(snakemake: Any) -> Iterator[dict[str, Any]]:
    """Yield `seed` and `checkpoint` of a job; delete the checkpoint if the job succeeds."""
    checkpoint = Path(snakemake.params.checkpoint)
    with job(snakemake.log[0]):
        torch.set_num_threads(snakemake.threads)
        yield {"seed": snakemake.params.seed, "checkpoint": checkpoint}
        checkpoint.unlink(missing_ok=True)
