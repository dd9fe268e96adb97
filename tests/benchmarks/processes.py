"""Whole processes: the first compiled EKF from the disk cache, and `fmuid run scara`."""

from __future__ import annotations

import pickle
import resource
import subprocess
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from pipeline.paths import ROOT
from tests.benchmarks.figure import Figure, at_most
from tests.benchmarks.filters import ekf, open_scara
from tests.benchmarks.record import scara
from tests.benchmarks.turns import in_turn, spread

ROUNDS = 7
FIRST = """
import pickle, sys
from pathlib import Path
from pipeline.identify.ekf import Tuning, run_filter
from pipeline.plant.binding import load_binding
from pipeline.plant.plant import open_plant
binding, arrays, tuning = pickle.loads(Path(sys.argv[1]).read_bytes())
with open_plant(load_binding(binding), "filter", "ME", "euler", engine="compiled") as plant:
    assert run_filter(plant, *arrays, Tuning(*tuning), "forward", "joseph").failed_at is None
"""


def measure() -> Iterator[Figure]:
    """CPU seconds of child processes, started in turn."""
    record = scara()
    with TemporaryDirectory() as folder, open_scara() as plant:
        data, r = Path(folder) / "record", record
        arrays, tuning = (r.time, r.q, r.u, r.z0, r.P0), (r.tuning.R, r.tuning.q, r.tuning.input_noise)
        data.write_bytes(pickle.dumps(("scara", arrays, tuning)))
        first = partial(_python, "-c", FIRST, str(data))
        whole = partial(_python, "-m", "pipeline.cli", "run", "scara", "--json", "--output", f"{folder}/run")
        times = in_turn({"first": first, "run": whole}, ROUNDS, children)
        warm = np.median(in_turn({"warm": partial(ekf, plant, record)}, ROUNDS)["warm"])
    yield at_most("first EKF of a process − a warm one, CPU s", spread(times["first"] - warm), "s CPU", 1.0)
    yield at_most("`fmuid run scara`, FMUs built, CPU s", spread(times["run"]), "s CPU", 4.0)


def children() -> float:
    """CPU seconds of the child processes that have ended."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def _python(*arguments: str) -> None:
    subprocess.run([sys.executable, *arguments], cwd=ROOT, check=True, capture_output=True)
