"""Translated equations evaluated in Python, against NumPy and closed forms; no C compiler involved."""

import casadi as ca
import numpy as np
import pytest

from pipeline.errors import ExportError
from tests.export.language import model_of


def evaluate(model, states=None, **values):
    """Derivatives and algebraic variables by name, at start values where nothing else is given."""
    numbers = {v.name: v.start for kind in ("constant", "parameter", "input") for v in model.variables[kind]} | values
    for variable, value in zip(model.variables["calculated"], ca.vertsplit(model.calculated), strict=True):
        numbers[variable.name] = substitute(value, numbers)
    for kind in ("state", "discrete"):
        for variable in model.variables[kind]:
            numbers.setdefault(variable.name, substitute(model.starts[variable.name], numbers))
    numbers |= {"time": 0.0} | (states or {})
    names = [v.name for kind in ("derivative", "algebraic") for v in model.variables[kind]]
    expressions = ca.vertsplit(ca.vertcat(model.derivatives, model.algebraics))
    solved = {name: substitute(value, numbers) for name, value in zip(names, expressions, strict=True)}
    return numbers | solved


def substitute(value, numbers):
    symbols = ca.symvar(value)
    if not symbols:
        return float(value)
    return float(ca.substitute(value, ca.vertcat(*symbols), ca.DM([numbers[s.name()] for s in symbols])))


def test_a_matrix_equation_is_solved_for_the_derivatives(tmp_path):
    text = """
    model M
      parameter Integer n=3;
      parameter Real M[n,n]=[2,0.1,0;0.1,1,0.2;0,0.2,3];
      parameter Real K[n]={1,2,3};
      Real q[n](start={0.1,0.2,0.3}, each fixed=true);
      Real qd[n](each start=0.5, each fixed=true);
    equation
      der(q) = qd;
      M*der(qd) = -K.*q + transpose(M)*qd;
    end M;
    """
    M, q, qd = np.array([[2, 0.1, 0], [0.1, 1, 0.2], [0, 0.2, 3]]), np.array([0.1, 0.2, 0.3]), np.full(3, 0.5)
    expected = np.linalg.solve(M, -np.array([1, 2, 3]) * q + M.T @ qd)
    values = evaluate(model_of(tmp_path, text))
    assert [values[f"der(qd[{i}])"] for i in (1, 2, 3)] == pytest.approx(expected, rel=1e-13)
    assert values["M[2,3]"] == 0.2


def test_for_families_sums_and_array_indices(tmp_path):
    text = """
    model M
      parameter Integer n=4;
      input Real u;
      Real y[n];
      Real total=sum(y);
      Real square[2,2];
      Real corner=square[2,1];
      Real row[2]=square[1,:];
    equation
      y[1] = u;
      for i in 2:n loop
        y[i] = i*y[i-1] + time;
      end for;
      for i in 1:2 loop
        for j in 1:2 loop
          square[i,j] = 10*i + j;
        end for;
      end for;
    end M;
    """
    values = evaluate(model_of(tmp_path, text), u=2.0)
    assert [values[f"y[{i}]"] for i in (1, 2, 3, 4)] == [2, 4, 12, 48]
    assert values["total"] == 66 and values["corner"] == 21
    assert [values["row[1]"], values["row[2]"]] == [11, 12]


def test_functions_of_assignments_are_written_out(tmp_path):
    text = """
    function f
      input Real x;
      input Real y;
      output Real z;
    protected
      Real w;
    algorithm
      w := x*x;
      z := w + y;
      z := 2*z;
    end f;
    model M
      input Real u;
      Real a=f(u, 3) + f(f(1, 2), u);
    end M;
    """
    values = evaluate(model_of(tmp_path, text), u=5.0)
    assert values["a"] == 2 * (25 + 3) + 2 * (36 + 5)


def test_functions_of_several_results_and_of_arrays(tmp_path):
    text = """
    function f
      input Real x;
      output Real a;
      output Real b;
    algorithm
      a := 2*x;
      b := 3*a;
    end f;
    function total
      input Real x[:];
      output Real y;
    algorithm
      y := sum(x) + size(x, 1);
    end total;
    model M
      input Real u;
      Real p;
      Real q;
      Real r=total({u, p, q});
      Real A[2,2]=3*identity(2) + fill(1, 2, 2);
    equation
      (p, q) = f(u);
    end M;
    """
    values = evaluate(model_of(tmp_path, text), u=5.0)
    assert (values["p"], values["q"], values["r"]) == (10, 30, 48)
    assert (values["A[1,1]"], values["A[1,2]"]) == (4, 1)


@pytest.mark.parametrize("x", [-0.7, 0.0, 0.3, 2.5])
def test_elementary_functions(tmp_path, x):
    text = """
    model M
      input Real x;
      Real a=noEvent(if x > 0 then sqrt(x) elseif x < -0.5 then -1 else 0);
      Real b=smooth(0, if x > 0.2 then x - 0.2 else 0) + abs(x) + sign(x);
      Real c=max(min(x, 1), -0.5) + atan2(x, 2) + exp(-x)*tanh(x)^3;
      Real d=max({x, 0.1, 0.2}) + product({x, 2, 3}) + {1, 2}*{x, 3};
      Real e=homotopy(sin(x), x);
    end M;
    """
    values = evaluate(model_of(tmp_path, text), x=x)
    assert values["a"] == (np.sqrt(x) if x > 0 else -1 if x < -0.5 else 0)
    assert values["b"] == pytest.approx(max(x - 0.2, 0) + abs(x) + np.sign(x))
    assert values["c"] == pytest.approx(max(min(x, 1), -0.5) + np.arctan2(x, 2) + np.exp(-x) * np.tanh(x) ** 3)
    assert values["d"] == pytest.approx(max(x, 0.2) + 6 * x + x + 6)
    assert values["e"] == pytest.approx(np.sin(x))


def test_records_and_connectors_are_their_components(tmp_path):
    text = """
    model M
      record R
        Real a;
        Real b;
      end R;
      connector Pin
        Real v;
        flow Real i;
      end Pin;
      model Resistor
        parameter Real R=1;
        Pin p;
        Pin n;
      equation
        p.v - n.v = R*p.i;
        p.i + n.i = 0;
      end Resistor;
      model Source
        parameter Real V=0;
        Pin p;
      equation
        p.v = V;
      end Source;
      R r=R(1, time);
      Source battery(V=10);
      Source ground;
      Resistor a(R=2);
      Resistor b(R=3);
      Real v=a.n.v;
    equation
      connect(battery.p, a.p);
      connect(a.n, b.p);
      connect(b.n, ground.p);
    end M;
    """
    values = evaluate(model_of(tmp_path, text), states={"time": 4.0})
    assert (values["r.a"], values["r.b"]) == (1, 4)
    assert values["v"] == pytest.approx(6.0) and values["b.n.i"] == pytest.approx(-2.0)


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
    assert {v.name for v in model.variables["parameter"] if v.tunable} == {"m", "internalStep"}
    values = evaluate(model, m=3.0)
    assert values["der(x)"] == pytest.approx(-2 * 3 * 9.81 * (3 * 9.81 / 10) + 4)


def test_start_values_replace_bindings(tmp_path):
    text = "model M parameter Real a=1; parameter Real b=2*a; Real x(start=b, fixed=true); equation der(x) = b; end M;"
    assert evaluate(model_of(tmp_path, text, a=4.0))["der(x)"] == 8
    assert evaluate(model_of(tmp_path, text, b=5.0))["x"] == 5
    with pytest.raises(ExportError, match="no parameter to set: c; settable: a"):
        model_of(tmp_path, text, c=1.0)


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
