"""The console command as a user meets it: in a process of its own."""

import json
import os
import subprocess
import sys

import pytest

from pipeline.cli import main


def fmuid(*arguments, **options):
    return subprocess.run(
        [sys.executable, "-m", "pipeline.cli", *arguments], capture_output=True, text=True, timeout=300, **options
    )


def imported(*arguments) -> set[str]:
    """The modules that a command imports."""
    command = [sys.executable, "-X", "importtime", "-m", "pipeline.cli", *arguments]
    lines = subprocess.run(command, capture_output=True, text=True).stderr.splitlines()
    return {line.rpartition("|")[2].strip() for line in lines}


def test_help_names_the_commands_and_loads_nothing_heavy():
    result = fmuid("--help")
    assert result.returncode == 0
    for command in ("build", "simulate", "identify", "run", "excite", "report"):
        assert command in result.stdout
    found = imported("--help")
    assert "pipeline.arguments" in found
    assert not {"numpy", "pandas", "scipy", "fmpy", "bokeh", "msgspec"} & found


def test_a_mistake_is_answered_before_the_slow_imports():
    found = imported("run", "scarra")
    assert "pipeline.config" in found
    assert not {"scipy", "control", "numba", "pyarrow.parquet"} & found


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (["run", "scarra"], 2, "no experiment `scarra`"),
        (["run", "scara", "--set", "ekf.substep=8"], 2, "did you mean `substeps`?"),
        (["run", "emps", "--data", "/nowhere"], 2, "no such data file in /nowhere; get it from the EMPS benchmark"),
        (["report", "nowhere"], 2, "not found"),
        (["simulate", "scara", "--set", "simulation.identification='none.csv'"], 2, "no such file"),
    ],
)
def test_a_mistake_is_one_line_with_its_exit_code(arguments, code, message):
    result = fmuid(*arguments)
    assert result.returncode == code
    assert result.stderr.startswith("fmuid: ") and message in result.stderr
    assert result.stderr.count("\n") == 1 and result.stdout == ""


def test_a_missing_compiler_is_one_line(tmp_path):
    environment = {**os.environ, "PATH": str(tmp_path), "CC": ""}
    result = fmuid("build", "--force", env=environment)
    assert result.returncode == 3
    assert result.stderr.startswith("fmuid: ") and "compiler" in result.stderr.splitlines()[-1]


def test_simulate_gives_json_and_the_file_that_was_asked_for(fmus, tmp_path):
    result = fmuid("simulate", "scara", "--json", "--output", str(tmp_path / "run.csv"))
    rows = (tmp_path / "run.csv").read_text().splitlines()
    assert result.returncode == 0 and len(json.loads(result.stdout)["time"]) == len(rows) - 1


def test_simulate_gives_json_and_csv(fmus):
    result = fmuid("simulate", "scara", "--json")
    frame = json.loads(result.stdout)
    assert len(frame["time"]) == len(frame["q_1"]) > 2000
    table = fmuid("simulate", "scara").stdout.splitlines()
    assert table[0].startswith("time [s],q_1 [rad],") and len(table) == len(frame["time"]) + 1
    other = fmuid("simulate", "scara", "--seed", "2").stdout.splitlines()
    assert other != table


def test_excite_writes_the_trajectory_and_says_what_it_is_worth(fmus, tmp_path):
    file = tmp_path / "w.csv"
    small = ["--set", "excitation.starts=1", "--set", "excitation.iterations=10", "--set", "excitation.segments=8"]
    small += ["--set", "excitation.condition_number_W=1e6", "--set", "excitation.condition_number_Phi=1e6"]
    result = fmuid("excite", "scara", "--json", "--output", str(file), *small)
    assert result.returncode == 0, result.stderr
    found = json.loads(result.stdout)
    assert found["trajectory"] == str(file) and file.read_text().count("\n") == 10
    assert "best so far" in result.stderr and "\r" not in result.stderr
    assert max(max(joints) for joints in found["used"].values()) <= 1.0
    result = fmuid("excite", "scara", "--output", str(tmp_path / "w.parquet"))
    assert result.returncode == 2 and "name a .csv file" in result.stderr and result.stderr.count("\n") == 1
    result = fmuid("excite", "scara", "--output", str(tmp_path / "none" / "w.csv"))
    assert result.returncode == 2 and "cannot be written there" in result.stderr and result.stderr.count("\n") == 1


def test_a_design_that_cannot_be_written_in_the_end_goes_to_stdout(fmus, tmp_path, monkeypatch, capsys):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pipeline.simulate.trajectory.write_waypoints", full)
    small = ["excitation.starts=1", "excitation.iterations=5", "excitation.segments=8"]
    options = [part for setting in small for part in ("--set", setting)]
    assert main(["excite", "emps", "--output", str(tmp_path / "w.csv"), *options]) == 2
    out, err = capsys.readouterr()
    assert out.startswith("time [s],q_1 [m],") and out.count("\n") == 10
    assert "w.csv: cannot be written (No space left on device); the design goes to stdout instead" in err


QUICK = ["--set", "ekf.case=[]"]


def test_identify_prints_every_estimate_or_json(fmus):
    text = fmuid("identify", "scara", *QUICK)
    assert text.returncode == 0 and "WLS(3)\n  ZZR1" in text.stdout and "sigma withheld" in text.stdout
    estimates = json.loads(fmuid("identify", "scara", "--json", *QUICK).stdout)
    assert list(estimates) == ["WLS(1)", "WLS(2)", "WLS(3)", "RLS"]
    assert abs(estimates["WLS(3)"]["parameters"]["ZZR1"]["value"] - 3.42) < 0.05


def test_run_prints_the_verdict_and_the_page_and_report_makes_it_again(fmus, tmp_path):
    folder = tmp_path / "run"
    result = fmuid("run", "scara", "--output", str(folder), *QUICK)
    assert result.returncode == 0 and result.stdout.startswith("PASS")
    page = folder / "index.html"
    assert result.stdout.splitlines()[-1] == str(page)
    first = page.read_bytes()
    page.unlink()
    again = fmuid("report", str(folder), "--json")
    assert json.loads(again.stdout) == {"report": str(page)}
    assert page.read_bytes() == first


def test_a_violated_limit_is_exit_code_1(fmus, tmp_path):
    limit = ["--set", "limits.above_noise_floor_percent=0.0", "--set", "limits.truth_sigmas=0.01"]
    result = fmuid("run", "scara", "--output", str(tmp_path / "run"), *QUICK, *limit)
    assert result.returncode == 1 and result.stdout.startswith("FAIL")


def test_a_failed_stage_has_its_own_exit_code_and_still_a_page(fmus, tmp_path):
    broken = ["--set", "wls.WLS(3).parallel.cutoff=0.001", "--set", "wls.WLS(3).decimation=10"]
    result = fmuid("run", "scara", "--output", str(tmp_path / "run"), *QUICK, *broken)
    assert result.returncode == 4 and "not identifiable apart" in result.stderr
    assert (tmp_path / "run" / "index.html").is_file()


def test_a_border_that_leaves_nothing_is_told_before_anything_is_simulated(fmus, tmp_path):
    result = fmuid("run", "scara", "--output", str(tmp_path / "run"), *QUICK, "--set", "wls.WLS(3).border=[2000, 2000]")
    assert result.returncode == 2 and "leaves none of 2501 samples" in result.stderr
    assert result.stderr.count("\n") == 1 and not (tmp_path / "run").exists()


def test_a_damaged_record_is_one_line(fmus, tmp_path):
    folder = tmp_path / "run"
    fmuid("run", "scara", "--output", str(folder), *QUICK)
    record = json.loads((folder / "result.json").read_text())
    record["estimates"]["WLS(3)"]["parameters"]["ZZR1"] = "x"
    (folder / "result.json").write_text(json.dumps(record))
    result = fmuid("report", str(folder))
    assert result.returncode == 2 and "its record is damaged" in result.stderr and result.stderr.count("\n") == 1
