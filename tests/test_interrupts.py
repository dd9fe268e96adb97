"""A signal that comes while an FMU logs ends the command, although the exception would be lost there."""

import os
import signal
import subprocess
import sys
import time

import pytest
import tomli_w
from msgspec import to_builtins

from tests.plant.moody import build_moody, moody_binding

CODE = """
import sys, tempfile
import numpy as np
from pipeline.cli import main, COMMANDS
from pipeline.identify.ekf import Tuning, run_filter
from pipeline.plant.binding import load_binding
from pipeline.plant.plant import open_plant

def command(arguments):
    N = 200_000
    with open_plant(load_binding(sys.argv[1]), "filter", "ME", "rk4", 4, sys.argv[2]) as plant:
        time, q = 0.01 * np.arange(N), np.zeros((N, 1))
        print("running", flush=True)
        run_filter(plant, time, q, q, np.array([0.0, 0.0, 2.0, 3.0]), np.eye(4), Tuning(np.ones(1), np.ones(1), True))
    return 0

COMMANDS["report"] = command
sys.exit(main(["report", "x"]))
"""


@pytest.mark.parametrize("engine", ["compiled", "python"])
@pytest.mark.parametrize(
    ("number", "code", "word"), [(signal.SIGINT, 130, "interrupted"), (signal.SIGTERM, 143, "terminated")]
)
def test_a_flood_of_messages_keeps_no_signal_from_ending_it(tmp_path, engine, number, code, word):
    (tmp_path / "tmp").mkdir()
    binding = moody_binding(build_moody(tmp_path), "GetDerivatives", 0, 0.0, flood=20)
    table = {k: v for k, v in to_builtins(binding).items() if k != "folder"}
    (tmp_path / "moody.toml").write_text(tomli_w.dumps(table))
    environment = {**os.environ, "TMPDIR": str(tmp_path / "tmp")}
    process = subprocess.Popen(
        [sys.executable, "-c", CODE, str(tmp_path / "moody.toml"), engine],
        env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdout.readline() == "running\n"
    time.sleep(3.0)  # into the filter, whose kernels may have to be compiled first
    process.send_signal(number)
    _, said = process.communicate(timeout=60)
    assert process.returncode == code
    assert said.strip() == f"fmuid: {word}"
    assert not list((tmp_path / "tmp").iterdir())
