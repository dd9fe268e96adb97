"""The front end: places, the experiment annotation, refusals before any translation."""

import copy

import pytest

from pipeline.errors import ExportError
from pipeline.export import frontend
from tests.export.language import source_of

MODEL = """model M "A decay"
  Real x(start=1, fixed=true);
equation
  der(x) = -x;
  annotation (experiment(StartTime=1, StopTime=2.5e1, Interval=1e-3, Tolerance=1E-6));
end M;
"""


@pytest.fixture
def source(tmp_path):
    return source_of(tmp_path, MODEL)


def test_an_entry_has_a_place(source):
    assert source.place(source.dae["continuous_equation_operations"][0]).endswith("M.mo:4")
    assert source.place({}) == ""


def test_the_experiment_annotation(source):
    assert source.experiment() == {"StartTime": 1, "StopTime": 25, "Interval": 1e-3, "Tolerance": 1e-6}


def test_an_error_of_the_front_end_is_one_line(tmp_path):
    with pytest.raises(ExportError, match="M: the Modelica front end refuses it") as error:
        source_of(tmp_path, "model M Real x; equation x = y; end M;")
    assert "\n" not in str(error.value)


def test_a_model_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(ExportError, match="P.Missing"):
        source_of(tmp_path, MODEL, "P.Missing")


@pytest.mark.parametrize("key", [*frontend.REFUSED, "a_section_of_tomorrow"])
def test_a_section_that_nothing_translates_is_refused(source, key):
    dae = copy.deepcopy(source.dae) | {key: [{"something": 1}]}
    with pytest.raises(ExportError, match="cannot be exported"):
        frontend.check_complete(frontend.Source(source.model, dae, source.flat, source.files))


@pytest.mark.parametrize("key", frontend.KINDS_OF_ENTRIES)
def test_an_entry_of_an_unknown_kind_is_refused(source, key):
    dae = copy.deepcopy(source.dae) | {key: [{"novelty": 1}]}
    with pytest.raises(ExportError, match=f"an entry of {key} with novelty"):
        frontend.check_complete(frontend.Source(source.model, dae, source.flat, source.files))


def test_another_schema_of_the_front_end_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(frontend, "SCHEMA", 42)
    with pytest.raises(ExportError, match="schema 43, not 42: install rumoca==0.10.2"):
        source_of(tmp_path, MODEL)


def test_a_lost_modifier_is_refused_with_its_place(tmp_path):
    text = """package M
  model F1 parameter Real c=1; end F1;
  model G replaceable model F = F1; F f; end G;
  model H extends G(redeclare model F = F1(c=5)); Real x=f.c; end H;
end M;
"""
    (tmp_path / "M.mo").write_text(text)
    with pytest.raises(ExportError, match=r"redeclare with a modifier.*M\.mo:4"):
        frontend.load(tmp_path / "M.mo", "M.H")
