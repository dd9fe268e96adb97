"""Linear systems of expressions: LDLᵀ and QR against NumPy, and which of them may be used."""

import casadi as ca
import numpy as np
import pytest

from pipeline.export.linear import is_definite, solve_linear
from pipeline.export.sorting import Equation, solve


def definite_matrix(n, seed, sign=1.0):
    """A symmetric matrix (n, n) with eigenvalues from 1 to 1e4, of one sign."""
    Q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(n, n)))
    M = sign * (Q * np.geomspace(1, 1e4, n)) @ Q.T
    return (M + M.T) / 2


def solution(A, b, definite):
    """x (n,) of solve_linear for numbers."""
    n = len(b)
    symbols, right = ca.SX.sym("A", n, n), ca.SX.sym("b", n)
    f = ca.Function("f", [symbols, right], [ca.vertcat(*solve_linear(symbols, right, definite))])
    return f(A, b).full().ravel()


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("definite", [True, False])
@pytest.mark.parametrize("n", [1, 2, 3, 7, 12])
def test_definite_systems_are_solved_to_round_off(n, definite, sign):
    A, x = definite_matrix(n, n, sign), np.linspace(-1, 2, n)
    assert solution(A, A @ x, definite) == pytest.approx(x, abs=1e-10)


def test_only_the_lower_triangle_is_read():
    A, x = definite_matrix(4, 0), np.arange(4.0)
    assert solution(np.tril(A), A @ x, True) == pytest.approx(x, abs=1e-10)


def test_what_vanishes_costs_nothing():
    n, u = 20, ca.SX.sym("u")
    band = ca.SX(ca.Sparsity.banded(n, 1), 1) + (2 + u**2) * ca.SX.eye(n)
    f = ca.Function("f", [u], [ca.vertcat(*solve_linear(band, ca.SX.ones(n), True))])
    assert f.n_instructions() < 12 * n
    assert f(1.0).full().ravel() == pytest.approx(
        np.linalg.solve(ca.evalf(ca.substitute(band, u, 1.0)).full(), [1.0] * n)
    )


def test_symmetric_systems_of_one_sign_are_definite_and_no_others():
    p, x = ca.SX.sym("p"), ca.SX.sym("x")
    A = ca.SX(definite_matrix(4, 1)) + p * ca.SX.eye(4)
    assert is_definite(A, {"p": 1.0}) and is_definite(-A, {"p": 1.0})
    assert not is_definite(A, {"p": -10.0})
    asymmetric = ca.SX(A)
    asymmetric[0, 3] += 1e-3 * ca.sin(x)
    assert not is_definite(asymmetric, {"p": 1.0})
    assert not is_definite(A / ca.sqrt(-1 - x**2), {"p": 1.0})


@pytest.mark.parametrize(
    "turn", [lambda s: s * ca.SX.sym("p"), lambda s: ca.if_else(s > 50, 1, 0), lambda s: ca.fmax(0, s - 9)]
)
def test_symmetry_that_ends_somewhere_is_none(turn):
    """A parameter whose default is 0, a relation, a function: at the values that are tried the matrix is symmetric."""
    A = ca.SX(definite_matrix(4, 1))
    A[0, 3] += turn(ca.SX.sym("s"))
    assert not is_definite(A, {"p": 0.0})


@pytest.mark.parametrize("p, operations", [(3.0, "few"), (0.1, "many")])
def test_sorting_takes_the_values_of_the_parameters_into_account(p, operations):
    """The same equations: definite for one value, and then with fewer operations; right for both."""
    n, symbol, u = 6, ca.SX.sym("p"), ca.SX.sym("u")
    rng = np.random.default_rng(0)
    B = rng.uniform(-0.3, 0.3, (n, n))
    unknowns, diagonal = [ca.SX.sym(f"x{i}") for i in range(n)], ca.SX.sym("d")
    residuals = ca.vertsplit((B + B.T + diagonal * ca.SX.eye(n)) @ ca.vertcat(*unknowns) - u)
    equations = [Equation(diagonal - symbol * ca.cos(0)), *map(Equation, residuals)]
    found = solve(equations, [*unknowns, diagonal], "M", {"p": p})
    f = ca.Function("f", [symbol, u], [ca.vertcat(*found[:n])])
    assert f(p, 2.0).full().ravel() == pytest.approx(np.linalg.solve(B + B.T + p * np.eye(n), np.full(n, 2.0)))
    assert (f.n_instructions() < 250) == (operations == "few")
