"""A dry run: the configuration it prints runs the same again, the stages say what is there; nothing is written."""

import json
import os
import subprocess
import sys
import tomllib

import pytest

from pipeline.paths import BINDINGS
from pipeline.workflow.plan import configuration, plan, plan_text
from pipeline.workflow.session import open_session


@pytest.mark.parametrize("overrides", [["ekf.substeps=8", "simulation.loop=clean"], []])
@pytest.mark.parametrize(("name", "simulated"), [("scara", False), ("emps", False), ("emps", True)])
def test_the_configuration_says_the_same_from_another_folder(name, simulated, overrides, tmp_path):
    session = open_session(name, overrides, simulated=simulated)
    text = plan_text(plan(session, "run"))
    assert tomllib.loads(text) == configuration(session)
    (tmp_path / "again.toml").write_text(text)
    again = open_session(str(tmp_path / "again.toml"))
    assert configuration(again) == configuration(session)
    assert again.experiment.name == name and again.experiment.ekf == session.experiment.ekf


def test_paths_of_an_own_experiment_become_absolute(tmp_path):
    (tmp_path / "data").mkdir()
    text = plan_text(plan(open_session("emps", ["controller.fmu=mine.fmu", "data.folder=data"]), "run"))
    (tmp_path / "mine.toml").write_text(text.replace('plant = "emps"', 'plant = "mine_binding.toml"'))
    (tmp_path / "mine_binding.toml").write_text((BINDINGS / "emps.toml").read_text())
    found = configuration(open_session(str(tmp_path / "mine.toml"), data=str(tmp_path / "data")))
    assert found["plant"] == str(tmp_path / "mine_binding.toml")
    assert found["data"]["folder"] == str(tmp_path / "data")
    assert os.path.isabs(found["controller"]["fmu"])


def dry(*arguments, cwd, **variables):
    command = [sys.executable, "-m", "pipeline.cli", *arguments, "--dry-run"]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p), **variables}
    return subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True, timeout=60)


@pytest.mark.parametrize("command", ["simulate", "identify", "run", "excite"])
def test_a_dry_run_writes_nothing_and_builds_nothing(command, tmp_path):
    empty, cache = tmp_path / "empty", tmp_path / "cache"
    empty.mkdir()
    result = dry(command, "scara", "--json", cwd=empty, FMUID_CACHE=str(cache))
    assert result.returncode == 0 and result.stderr == ""
    stages = {stage["name"]: stage for stage in json.loads(result.stdout)["stages"]}
    assert all("scara" in path and "(to be built)" in path for path in stages["FMUs"]["outputs"])
    assert ("page" in stages) == (command == "run") and ("EKF" in stages) == (command in ("identify", "run"))
    assert list(empty.iterdir()) == [] and not cache.exists()


def test_a_dry_run_tells_what_is_missing_and_refuses_what_is_wrong(tmp_path):
    result = dry("run", "emps", "--data", "/nowhere", cwd=tmp_path)
    assert result.returncode == 0 and "/nowhere/DATA_EMPS.mat (MISSING)" in result.stdout
    result = dry("run", "emps", "--set", "ekf.substep=8", cwd=tmp_path)
    assert result.returncode == 2 and result.stdout == "" and "did you mean `substeps`?" in result.stderr
