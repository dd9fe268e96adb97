"""Linear systems A x = b of expressions. No pivot can be chosen in them: what is divided by must not vanish."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import casadi as ca
import numpy as np

SAMPLES = 5
ROUND_OFF = 1e-12
SAME_DEPTH = 100  # how deep two expressions are compared


def solve_linear(A: ca.SX, b: ca.SX, definite: bool) -> list[ca.SX]:
    """The solution x (n,) of A x = b, A (n, n), b (n,): by LDLᵀ where A is symmetric and definite, else by QR."""
    if A.size1() == 1:
        return [b / A]
    if A.size1() == 2:
        return cramer(A, b)
    return ldl(A, b) if definite else qr(A, b)


def cramer(A: ca.SX, b: ca.SX) -> list[ca.SX]:
    """The solution of two equations, in fewer operations than any factorisation."""
    det = A[0, 0] * A[1, 1] - A[0, 1] * A[1, 0]
    return [(A[1, 1] * b[0] - A[0, 1] * b[1]) / det, (A[0, 0] * b[1] - A[1, 0] * b[0]) / det]


def ldl(A: ca.SX, b: ca.SX) -> list[ca.SX]:
    """The solution by A = L D Lᵀ, from the lower triangle of A: n³/3 operations (QR: 2 n³), n of them divisions."""
    n = A.size1()
    L, LD, inverse, y = {}, {}, [], []
    for j in range(n):
        for i in range(j, n):
            LD[i, j] = minus(A[i, j], ((LD[i, k], L[j, k]) for k in range(j)))
        inverse.append(1 / LD[j, j])
        L |= {(i, j): LD[i, j] * inverse[j] for i in range(j + 1, n)}
        y.append(minus(b[j], ((L[j, k], y[k]) for k in range(j))))
    x = {}
    for j in reversed(range(n)):
        x[j] = minus(y[j] * inverse[j], ((L[i, j], x[i]) for i in range(j + 1, n)))
    return [x[j] for j in range(n)]


def qr(A: ca.SX, b: ca.SX) -> list[ca.SX]:
    """The solution by A = Q R, through the QR of [A b]: by Gram and Schmidt, Qᵀb would lose as many digits as Q does.

    Å. Björck, Numerical Methods for Least Squares Problems (1996), section 2.4.
    """
    n = A.size1()
    _, R = ca.qr(ca.densify(ca.blockcat([[A, b], [ca.SX.zeros(1, n), 1]])))
    return ca.vertsplit(ca.solve(R[:n, :n], R[:n, n]))


def minus(value: ca.SX, factors: Iterable[tuple[ca.SX, ca.SX]]) -> ca.SX:
    """value - Σ p q."""
    for p, q in factors:
        value = value - p * q
    return value


def is_definite(A: ca.SX, numbers: Mapping[str, float]) -> bool:
    """True where A (n, n) is symmetric by its expressions, and its eigenvalues have one sign at `numbers` and random
    other values: symmetry at some values would be none where a relation or another parameter turns it.

    numbers: {symbol: value}, of the parameters: a mass matrix is definite for those of a robot, not for any.
    """
    n = A.size1()
    if not all(ca.is_equal(A[i, j], A[j, i], SAME_DEPTH) for i in range(n) for j in range(i)):
        return False
    symbols = ca.symvar(A)
    function = ca.Function("A", [ca.vertcat(*symbols)], [ca.densify(A)])
    rng = np.random.default_rng(0)
    for _ in range(SAMPLES):
        values = [numbers.get(symbol.name(), rng.uniform(-3, 3)) for symbol in symbols]
        M = function(values).full()
        size = np.abs(M).max()
        if not np.isfinite(size):
            return False
        eigenvalues = np.linalg.eigvalsh(M)
        if max(eigenvalues.min(), -eigenvalues.max()) <= ROUND_OFF * size:
            return False
    return True
