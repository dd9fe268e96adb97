"""Translated equations evaluated in Python, against NumPy and closed forms; no C compiler involved."""

import numpy as np
import pytest

from tests.export.language import evaluate, model_of


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
