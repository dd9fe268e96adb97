"""`fmuid build --modelica DIR --model Pkg.Model`: one FMU of other people's Modelica, or one line that says why not."""

import json

import pytest

from pipeline.cli import main
from tests.export.driver import Archive

PACKAGE = """package P
  model A parameter Real k=2; Real y=k*time; end A;
  model SlowFan Real y=time; end SlowFan;
end P;
"""


@pytest.fixture
def package(tmp_path, monkeypatch):
    """The folder P of a package, in the current folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "P").mkdir()
    (tmp_path / "P" / "package.mo").write_text(PACKAGE)
    return "P"


def value_at_one_second(path, folder):
    with Archive(path, folder).co_simulation() as instance:
        instance.step(0.0, 1.0)
        return instance.get("y")[0]


def test_the_fmu_is_written_here_under_the_models_name(package, tmp_path, capsys):
    assert main(["build", "--modelica", package, "--model", "P.SlowFan"]) == 0
    assert capsys.readouterr().out.startswith("slow_fan.fmu  built in")
    assert value_at_one_second(tmp_path / "slow_fan.fmu", tmp_path / "unpacked") == 1


def test_the_fmu_is_written_where_it_is_asked_for(package, tmp_path, capsys):
    assert main(["build", "--modelica", package, "--model", "P.A", "--output", "to/my-plant.fmu", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)[0]["path"] == "to/my-plant.fmu"
    assert value_at_one_second(tmp_path / "to" / "my-plant.fmu", tmp_path / "unpacked") == 2


def test_a_file_is_read_alone_and_a_folder_of_files_as_a_whole(package, tmp_path):
    (tmp_path / "a.mo").write_text("model M Real y=3*time; end M;")
    (tmp_path / "b.mo").write_text("model M Real y=4*time; end M;")
    (tmp_path / "files").mkdir()
    (tmp_path / "files" / "W.mo").write_text("model W extends V; end W;")
    (tmp_path / "files" / "V.mo").write_text("model V Real y=5*time; end V;")
    for source, model, expected in (("a.mo", "M", 3), ("b.mo", "M", 4), ("files", "W", 5)):
        assert main(["build", "--modelica", source, "--model", model, "--output", f"{expected}.fmu"]) == 0
        assert value_at_one_second(tmp_path / f"{expected}.fmu", tmp_path / source.replace(".", "_")) == expected


REFUSED = {
    "no model given": (["--modelica", "P"], "P: give --model, one of P.A, P.SlowFan"),
    "a model's name misspelt": (
        ["--modelica", "P", "--model", "P.SlowFin"],
        "P: no model P.SlowFin; the nearest: P.SlowFan; there are P.A, P.SlowFan",
    ),
    "no folder": (["--modelica", "Q", "--model", "P.A"], "Q: no such folder or file; give"),
    "a model unlike all": (["--modelica", "P", "--model", "zzz"], "P: no model zzz; there are P.A, P.SlowFan"),
    "no Modelica": (["--modelica", "empty", "--model", "P.A"], "empty: no model in it"),
    "no FMU's name": (
        ["--modelica", "P", "--model", "P.A", "--output", "a.zip"],
        "a.zip: an FMU's file name ends in .fmu",
    ),
    "names of our own": (["scara", "--modelica", "P"], "scara: with --modelica give the class by --model"),
    "an output for all": (["--output", "a.fmu"], "--output names the FMU of one --model"),
    "a folder of packages": (["--modelica", ".", "--model", "P.A"], ".: no package.mo and no other .mo file in it"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_built_is_refused_in_one_line(package, tmp_path, capsys, case):
    (tmp_path / "empty").mkdir()
    arguments, message = REFUSED[case]
    assert main(["build", *arguments]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"fmuid: {message}") and error.count("\n") == 1 and "Errno" not in error
