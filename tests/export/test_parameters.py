"""Parameters: settable, calculated, constant; start values from outside."""

import pytest

from pipeline.errors import ExportError
from tests.export.language import evaluate, model_of


def test_derived_final_and_constant_parameters(tmp_path):
    text = """
    model M
      constant Real g=9.81;
      parameter Real m=2;
      parameter Real k=m*g;
      parameter Real unused=3;
      final parameter Real twice=2*k;
      final parameter Real fixed=4;
      parameter Boolean on=true;
      parameter Real x_start=k/10;
      Real x(start=x_start, fixed=true);
    equation
      der(x) = if on then -twice*x + fixed else 0;
    end M;
    """
    model = model_of(tmp_path, text)
    kinds = {v.name: kind for kind, members in model.variables.items() for v in members}
    assert {name: kinds[name] for name in ("g", "m", "k", "twice", "fixed", "on")} == {
        "g": "constant", "m": "parameter", "k": "calculated", "twice": "calculated", "fixed": "constant",
        "on": "constant",
    }  # fmt: skip
    assert {v.name for v in model.variables["parameter"] if v.tunable} == {"m", "internalStep", "internalOrder"}
    values = evaluate(model, m=3.0)
    assert values["der(x)"] == pytest.approx(-2 * 3 * 9.81 * (3 * 9.81 / 10) + 4)


def test_parameters_of_a_running_model_are_tunable_but_those_of_sample_periods_and_starts(tmp_path):
    text = """
    model M
      parameter Real T=0.1;
      parameter Real double=2*T;
      parameter Real gain=3;
      parameter Real start=1;
      parameter Real level=0.5;
      parameter Real limit=9;
      parameter Real scale=2;
      discrete Real d(start=start, fixed=true);
      Real x(start=start, fixed=true, nominal=scale);
    equation
      der(x) = if time > level then d*double else 0;
      assert(x < limit, "x");
      when sample(0, double) then
        d = pre(d) + gain*T;
      end when;
    end M;
    """
    tunable = {v.name for v in model_of(tmp_path, text).variables["parameter"] if v.tunable}
    assert tunable == {"gain", "level", "limit", "internalStep", "internalOrder"}


def test_start_values_replace_bindings(tmp_path):
    text = "model M parameter Real a=1; parameter Real b=2*a; Real x(start=b, fixed=true); equation der(x) = b; end M;"
    assert evaluate(model_of(tmp_path, text, a=4.0))["der(x)"] == 8
    assert evaluate(model_of(tmp_path, text, b=5.0))["x"] == 5
    with pytest.raises(ExportError, match="no parameter to set: c; settable: a"):
        model_of(tmp_path, text, c=1.0)
