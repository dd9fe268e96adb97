"""What the README shows works as it stands there."""

import re

import pandas as pd
import pytest

from pipeline.paths import FMUS, ROOT
from pipeline.workflow.acquire import simulate
from pipeline.workflow.run import run
from pipeline.workflow.session import open_session

TEXT = (ROOT / "README.md").read_text()


def test_every_file_it_points_to_exists():
    for target in re.findall(r"\]\(([^)#:]+)\)", TEXT):
        assert (ROOT / target).exists(), target


@pytest.fixture
def own_plant(fmus, tmp_path):
    """The README's experiment in a folder of its own: an FMU, a binding, and data in units that nobody else uses."""
    example = re.search(r"```toml\n(.*?)```", TEXT, re.S)[1]
    (tmp_path / "my.toml").write_text(example.replace('"deg"', '"mm"'))  # the drive at hand is a slide
    (tmp_path / "my_binding.toml").write_text((FMUS / "emps.toml").read_text())
    (tmp_path / "emps.fmu").write_bytes((FMUS / "emps.fmu").read_bytes())
    for name, validation in (("run1.csv", False), ("run2.csv", True)):
        frame = simulate(open_session("emps", simulated=True), validation)
        columns = {"t": 1e3 * frame.index, "angle": 1e3 * frame["q_1"], "command": -frame["u_1"]}
        pd.DataFrame(columns).to_csv(tmp_path / name, index=False, sep=";")
    return tmp_path / "my.toml"


def test_the_whole_experiment_of_use_3_finds_the_drive(own_plant):
    folder, record = run(open_session(str(own_plant)), str(own_plant.parent / "report"))
    assert record["errors"] == [] and (folder / "index.html").is_file()
    truth = {"M": 95.1089, "Fv": 203.5034, "Fc": 20.3935, "offset": -3.1648}
    for name in ("WLS", "EKF"):
        for parameter, value in truth.items():
            assert abs(record["estimates"][name]["parameters"][parameter]["value"] / value - 1) < 0.05, (
                name,
                parameter,
            )
