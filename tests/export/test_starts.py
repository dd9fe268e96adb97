"""Start values of states and discrete variables, as they follow from parameters and initial equations."""

import casadi as ca
import pytest

from pipeline.errors import ExportError
from tests.export.language import evaluate, model_of


def test_initial_equations_for_states_and_discrete_variables(tmp_path):
    text = """
    model M
      parameter Real a=3;
      Real x;
      Real y;
      discrete Real d;
    initial equation
      2*x + y = a;
      der(y) = 0;
      pre(d) = a + 1;
    equation
      der(x) = -x;
      der(y) = x - 2*y;
      when sample(0, 1) then
        d = pre(d);
      end when;
    end M;
    """
    values = evaluate(model_of(tmp_path, text), a=5.0)
    assert (values["x"], values["y"], values["d"]) == pytest.approx((2.0, 1.0, 6.0))


def test_a_fixed_start_value_of_no_state_is_an_initial_equation(tmp_path):
    text = "model M Real x(start=3, fixed=true); Real y; equation y = 2*x; der(y) = -x; end M;"
    values = evaluate(model_of(tmp_path, text))
    assert (values["x"], values["y"]) == (3, 6)


def test_a_start_value_that_a_relation_decides_is_refused_by_the_relations_text(tmp_path):
    text = """model M
      Real x;
      Real y=if x > 0.2
        then sin(time) else 0;
    initial equation
      der(x) = 1;
    equation
      der(x) = y - x;
    end M;
    """
    message = r"the start value of x depends on the relation x > 0\.2 \(M\.mo:3\), which is not a parameter"
    with pytest.raises(ExportError, match=message):
        model_of(tmp_path, text)


def test_relations_with_the_same_text_are_told_apart(tmp_path):
    text = "model X Real x(start=1, fixed=true); Real y=if x > 0.2 then 1 else 0; equation der(x) = -y; end X;"
    model = model_of(tmp_path, f"{text} model M X a; X b; end M;")
    names = [symbol.name() for symbol in ca.symvar(model.events.r)]
    assert names == ["the relation x > 0.2 (M.mo:1)", "the relation x > 0.2 (M.mo:1) [2]"]
