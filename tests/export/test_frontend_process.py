"""Whatever a model does to the front end, the answer is one line."""

import pytest

from pipeline.errors import ExportError
from pipeline.export import frontend_process
from pipeline.export.frontend import load
from tests.export.language import source_of

CRASHES = """
  model G end G;
  model A replaceable model F = G; F f; end A;
  model B extends A; redeclare model extends F Real z=2; end F; end B;
"""
FAILS = {
    "a panic": ("input Real u; Real y=der(u);", r"der\(\) of an input, or of another variable that is no state"),
    "a syntax error": ("Real x = ;", r"syntax error: unexpected `;` \(M\.mo:2\)"),
    "a name that is not there": ("Real x = y; Foo z;", r"y is not declared \(M\.mo:2\): .*; the class Foo is not"),
}


@pytest.mark.parametrize("case", FAILS)
def test_a_failure_of_the_front_end_is_one_line(tmp_path, case):
    body, message = FAILS[case]
    with pytest.raises(ExportError, match=f"^M: the Modelica front end refuses it: {message}") as refusal:
        source_of(tmp_path, f"model M\n{body}\nend M;")
    assert "\n" not in str(refusal.value)


def test_a_crash_of_the_front_end_is_one_line(tmp_path):
    (tmp_path / "P.mo").write_text(f"package P {CRASHES} end P;")
    with pytest.raises(ExportError, match=r"it crashed \(exit code -11\): redeclare model extends") as refusal:
        load(tmp_path / "P.mo", "P.B")
    assert "\n" not in str(refusal.value)


def test_an_answer_that_does_not_come_is_not_waited_for(tmp_path, monkeypatch):
    monkeypatch.setattr(frontend_process, "PATIENCE", 1e-3)
    with pytest.raises(ExportError, match="no answer within 0.001 s"):
        source_of(tmp_path, "model M end M;")


def test_libraries_are_searched_in_modelicapath(tmp_path, monkeypatch):
    library = tmp_path / "libraries" / "Lib"
    library.mkdir(parents=True)
    (library / "package.mo").write_text("package Lib model A Real y=2*time; end A; end Lib;")
    monkeypatch.setenv("MODELICAPATH", str(library.parent))
    assert source_of(tmp_path, "model M extends Lib.A; end M;").dae["variables"][0]["name"] == "y"
