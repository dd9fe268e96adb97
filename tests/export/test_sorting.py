"""Sorting and solving against NumPy's linear solver, in any order of equations and unknowns."""

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.errors import ExportError
from pipeline.export.sorting import Equation, solve


def sparse_system(seed, n):
    """A matrix (n, n), diagonally dominant in a hidden order, and how to shuffle it."""
    rng = np.random.default_rng(seed)
    A = np.where(rng.random((n, n)) < 0.3, rng.uniform(-1, 1, (n, n)), 0.0)
    A[np.arange(n), rng.permutation(n)] = n + 1.0
    return A, rng.uniform(-1, 1, n), rng.permutation(n)


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 2**32 - 1), st.integers(1, 7))
def test_linear_systems_in_any_order(seed, n):
    A, b, order = sparse_system(seed, n)
    unknowns = [ca.SX.sym(f"x{i}") for i in range(n)]
    u = ca.SX.sym("u")
    residuals = ca.vertsplit(A[order] @ ca.vertcat(*unknowns) - b[order] * u)
    solution = solve([Equation(residual) for residual in residuals], unknowns, "M")
    f = ca.Function("f", [u], solution)
    values = [float(value) for value in (f(2.0) if n > 1 else [f(2.0)])]
    assert values == pytest.approx(np.linalg.solve(A, 2 * b), rel=1e-9, abs=1e-12)


def test_a_chain_is_non_linear_in_what_is_known_by_then():
    x, y, z, u = (ca.SX.sym(name) for name in "xyzu")
    equations = [Equation(z - ca.sin(y) * x), Equation(ca.exp(x) * y - u), Equation(x - u**2)]
    f = ca.Function("f", [u], solve(equations, [x, y, z], "M"))
    assert [float(v) for v in f(1.5)] == pytest.approx([2.25, 1.5 * np.exp(-2.25), np.sin(1.5 * np.exp(-2.25)) * 2.25])


def test_unknowns_of_the_same_name_in_another_order_stay_apart():
    names = ["b", "a", "c"]
    symbols = [ca.SX.sym(name) for name in names]
    equations = [Equation(symbol - i) for i, symbol in enumerate(symbols)]
    assert [float(v) for v in solve(equations[::-1], symbols, "M")] == [0, 1, 2]


@pytest.mark.parametrize(
    "equations, message",
    [
        (lambda x, y: [Equation(x - 1)], "1 equations for 2 unknowns"),
        (lambda x, y: [Equation(x - 1, "F.mo:3"), Equation(x * 2, "F.mo:4")], "rank 1 of 2.*undetermined: y"),
        (lambda x, y: [Equation(x - ca.sin(y), "F.mo:3"), Equation(y - x**2, "F.mo:4")], r"non-linear.*F\.mo:[34]"),
        (lambda x, y: [Equation(x - y), Equation(2 * x - 2 * y - 1)], "singular system of equations"),
    ],
)
def test_what_has_no_solution_is_refused(equations, message):
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    with pytest.raises(ExportError, match=message):
        solve(equations(x, y), [x, y], "M")
