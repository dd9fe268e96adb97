"""An installed wheel in an empty folder: it finds its models and bindings, builds the FMUs it needs, and reports."""

import json
import os
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

from pipeline.paths import ROOT


@pytest.fixture(scope="module")
def environment(tmp_path_factory):
    """A fresh virtual environment with the wheel in it; what the wheel needs is borrowed from this one."""
    pytest.importorskip("hatchling", reason="no hatchling, which builds the wheel: pip install '.[test]'")
    folder = tmp_path_factory.mktemp("wheel")
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, "wheel", "--no-build-isolation", "--no-deps", "-w", folder, ROOT], check=True)
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder / "fresh"], check=True)
    (wheel,) = folder.glob("*.whl")
    python = folder / "fresh" / "bin" / "python"
    subprocess.run([*pip, "--python", python, "install", "--no-deps", "--no-index", wheel], check=True)
    site = sysconfig.get_path("purelib", vars={"base": str(folder / "fresh")})
    borrowed = [entry for entry in sys.path if entry.endswith("site-packages")]
    with open(f"{site}/borrowed.pth", "w") as file:
        file.write("\n".join(borrowed) + "\n")
    return folder


def fmuid(environment, where, *arguments, **variables):
    where.mkdir(exist_ok=True)
    kept = {key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "FMUID"))}
    command = [environment / "fresh" / "bin" / "fmuid", *arguments]
    return subprocess.run(command, cwd=where, env=kept | variables, capture_output=True, text=True, timeout=300)


def test_an_experiment_runs_in_an_empty_folder(environment):
    where, cache = environment / "empty", str(environment / "cache")
    quick = ["--set", "ekf.case=[]", "--json"]
    result = fmuid(environment, where, "run", "scara", *quick, FMUID_CACHE=cache)
    assert result.returncode == 0, result.stderr
    assert "built scara.fmu" in result.stderr and "built scara_controller.fmu" in result.stderr
    printed = json.loads(result.stdout)
    assert [p.name for p in where.iterdir()] == ["reports"]
    assert printed["report"].startswith(str(where / "reports" / "scara-"))
    record = json.loads(Path(printed["record"]).read_text())
    assert record["provenance"]["commit"] is None and record["provenance"]["dirty"] is None
    again = fmuid(environment, where, "report", record["run_id"], "--json")
    assert json.loads(again.stdout) == {"report": printed["report"]}
    result = fmuid(environment, where, "simulate", "scara", "--output", "run.csv", FMUID_CACHE=cache)
    assert result.returncode == 0 and result.stderr == "", "what is up to date is not built again"


def test_the_wheel_knows_nothing_of_the_checkout(environment):
    code = "import pipeline.paths as p, sys; print(p.IN_CHECKOUT, p.ROOT, *sys.path, sep='\\n')"
    command = [environment / "fresh" / "bin" / "python", "-c", code]
    said = subprocess.run(command, cwd=environment, capture_output=True, text=True, check=True).stdout.split()
    assert said[0] == "False" and str(ROOT) not in said


def test_fmus_go_to_the_users_cache(environment):
    home = environment / "home"
    result = fmuid(environment, environment / "there", "build", "emps", XDG_CACHE_HOME=str(home))
    assert result.returncode == 0 and list(home.glob("fmuid/*/emps.fmu"))


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="no /proc, which nobody may write to")
def test_a_cache_that_cannot_be_written_is_one_line_with_the_remedy(environment):
    result = fmuid(environment, environment / "there", "simulate", "emps", "--simulated", FMUID_CACHE="/proc/cache")
    assert result.returncode == 3 and result.stdout == ""
    assert result.stderr.splitlines()[-1].startswith("fmuid: /proc/cache: cannot be written")
    assert "FMUID_CACHE" in result.stderr.splitlines()[-1]
