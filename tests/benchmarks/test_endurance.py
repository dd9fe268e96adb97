"""2,000 consecutive runs of the compiled EKF in one process neither leak nor leave temporary folders behind."""

import tempfile
from pathlib import Path

import pytest

from tests.benchmarks.filters import ekf, open_scara
from tests.benchmarks.record import scara

RUNS, SETTLED = 2000, 100
STATM = Path("/proc/self/statm")


def resident():
    """Pages that the process has in memory."""
    return int(STATM.read_text().split()[1])


@pytest.mark.skipif(not STATM.is_file(), reason="resident memory is read from /proc")
def test_consecutive_runs_leave_nothing_behind(fmus, tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    record, settled = scara().first(50), 0
    for k in range(RUNS):
        with open_scara() as plant:
            ekf(plant, record, covariance="udu")
        if k + 1 == SETTLED:
            settled = resident()
    assert resident() <= 1.05 * settled
    assert not list(tmp_path.iterdir())
