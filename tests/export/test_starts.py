"""Start values of states and discrete variables, as they follow from parameters and initial equations."""

import pytest

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
