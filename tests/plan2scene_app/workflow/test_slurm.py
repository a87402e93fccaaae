import pytest

from plan2scene.errors import InputError
from plan2scene_app.workflow.slurm import check_cluster, check_status, read_settings

SHOWN = """Configuration data as of 2026-11-22T06:00:00
AccountingStorageType   = accounting_storage/{}
MinJobAge               = {}
SlurmctldHost[0]        = vm(127.0.0.1)
"""


@pytest.mark.parametrize(
    ("command", "accounting", "kept", "fault"),
    [
        ("squeue", "none", "300 sec", None),
        ("squeue", "none", "60 sec", "accounting or a longer memory"),
        ("squeue", "slurmdbd", "60 sec", "--slurm-status-command sacct"),
        ("sacct", "slurmdbd", "2 sec", None),
        ("sacct", "none", "300 sec", "--slurm-status-command squeue"),
        ("squeue", "none", "", None),
    ],
)
def test_a_status_that_would_not_be_seen_is_a_fault(command, accounting, kept, fault):
    settings = read_settings(SHOWN.format(accounting, kept))
    if fault is None:
        check_status(settings, command)
    else:
        with pytest.raises(InputError) as caught:
            check_status(settings, command)
        assert caught.value.expected == fault


def test_without_a_slurm_the_line_says_so(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(InputError, match="a login node of a SLURM cluster"):
        check_cluster("squeue")
