"""Accelerations at many points and the torques that follow from them, compiled: the operations of `probing.py`.

All at time 0. Arrays by address; the states of N points stand side by side as the FMU has them, X (N, nx).
"""

from __future__ import annotations

from math import isfinite

from pipeline.plant.fmi_kernel import DERIVATIVES, failed, get_derivatives, set_states
from pipeline.plant.fmu import NOT_FINITE
from pipeline.plant.kernel import array_at, integers_at, kernel, matrix_at
from pipeline.plant.transition_kernel import prepare

POINTS = [
    (name, "i8") for name in (
        "N", "sets",
        # points q, qd, qdd (N, n); sets of parameters chi (sets, p), whether each has a mass of its own (sets,)
        "q", "qd", "qdd", "chi", "own",
        # what pushes: the inputs step (n,), which are the forces `force` (n,)
        "step", "force",
        # what is found: tau (sets, N, n)
        "tau",
        # room: X (N, nx), u and still (n,), free and pushed (N, n), J (2, N, n, n), A (n, n)
        "X", "u", "still", "free", "pushed", "J", "A",
    )
]  # fmt: skip
"""Fields of the record of points."""

DONE, PLANT_FAILED, SINGULAR = range(3)
"""What `torques` ends with."""


@kernel
def place(m, q, qd, N, X):
    """X from q, qd (N, n)."""
    n, order = m.n, integers_at(m.order, m.ns)
    positions, velocities, states = matrix_at(q, N, n), matrix_at(qd, N, n), matrix_at(X, N, m.nx)
    for g in range(N):
        for i in range(n):
            states[g, order[i]], states[g, order[n + i]] = velocities[g, i], positions[g, i]


@kernel
def accelerate(m, X, N, u, chi, qdd):
    """qdd (N, n) at the points X, all with the input u (n,) and the parameters chi (p,)."""
    n, order, s = m.n, integers_at(m.order, m.ns), array_at(m.stage, m.ns)
    first, dx, found = array_at(X, m.nx), array_at(m.dx, m.nx), matrix_at(qdd, N, n)
    for i in range(m.ns):
        s[i] = first[order[i]]
    if prepare(m, m.stage, u, chi, 0.0):
        return True
    m.evaluations += N
    for g in range(N):
        if set_states(m, X + 8 * g * m.nx, m.nx) or get_derivatives(m, m.dx, m.nx):
            return True
        total = 0.0
        for i in range(n):
            found[g, i] = dx[order[i]]
            total += found[g, i]
        if not isfinite(total):
            return failed(m, DERIVATIVES, NOT_FINITE)
    return False


@kernel
def respond(m, w, chi, J):
    """J (N, n, n) = ∂qdd/∂tau: column j is what the input step[j] alone adds to w.free. Whether the plant failed."""
    n, N = m.n, w.N
    step, force, u = array_at(w.step, n), array_at(w.force, n), array_at(w.u, n)
    free, pushed, J = matrix_at(w.free, N, n), matrix_at(w.pushed, N, n), matrix_at(J, N, n * n)
    for j in range(n):
        for i in range(n):
            u[i] = step[i] if i == j else 0.0
        if accelerate(m, w.X, N, w.u, chi, w.pushed):
            return True
        for g in range(N):
            for i in range(n):
                J[g, i * n + j] = (pushed[g, i] - free[g, i]) / force[j]
    return False


@kernel
def solve(A, x, n):
    """x (n,) ← A⁻¹ x, as `in_order.solve`; whether A (n, n), which is eliminated, was regular."""
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(A[i, k]) > abs(A[pivot, k]):
                pivot = i
        if not abs(A[pivot, k]) > 0.0:
            return False
        x[k], x[pivot] = x[pivot], x[k]
        for j in range(k, n):
            A[k, j], A[pivot, j] = A[pivot, j], A[k, j]
        for i in range(k + 1, n):
            factor = A[i, k] / A[k, k]
            for j in range(k + 1, n):
                A[i, j] -= factor * A[k, j]
            x[i] -= factor * x[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            x[k] -= A[k, j] * x[j]
        x[k] /= A[k, k]
    return True


@kernel
def _balance(m, w, J, tau):
    """tau (N, n) = J⁻¹ (qdd − free); whether J (N, n, n) is regular everywhere."""
    n, A = m.n, matrix_at(w.A, m.n, m.n)
    for g in range(w.N):
        at = 8 * g * n
        here, x = matrix_at(J + n * at, n, n), array_at(tau + at, n)
        qdd, free = array_at(w.qdd + at, n), array_at(w.free + at, n)
        for i in range(n):
            x[i] = qdd[i] - free[i]
            for j in range(n):
                A[i, j] = here[i, j]
        if not solve(A, x, n):
            return False
    return True


@kernel
def torques(plant, points):
    """tau (sets, N, n) at all points for every set of parameters; gives what it ended with.

    A set without a mass of its own has that of the first one.
    """
    m, w = plant[0], points[0]
    place(m, w.q, w.qd, w.N, w.X)
    own = integers_at(w.own, w.sets)
    for c in range(w.sets):
        chi, J = w.chi + 8 * c * m.p, w.J + 8 * w.N * m.n * m.n * (c > 0 and own[c])
        if accelerate(m, w.X, w.N, w.still, chi, w.free):
            return PLANT_FAILED
        if own[c] and respond(m, w, chi, J):
            return PLANT_FAILED
        if not _balance(m, w, J, w.tau + 8 * c * w.N * m.n):
            return SINGULAR
    return DONE


@kernel
def accelerate_once(plant, q, qd, N, X, u, chi, qdd):
    """`accelerate` at q, qd (N, n) for a record (1,) of Python's, X being room."""
    m = plant[0]
    place(m, q, qd, N, X)
    return accelerate(m, X, N, u, chi, qdd)
