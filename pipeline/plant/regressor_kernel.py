"""Accelerations at many points and the torques that follow from them, compiled: the operations of `probing.py`.

All at time 0. Arrays by address; the states of N points stand side by side as the FMU has them, X (N, nx).
"""

from __future__ import annotations

from math import isfinite

from pipeline.plant.fmi_kernel import DERIVATIVES, INPUTS, failed, get_derivatives, set_states, set_values
from pipeline.plant.fmu import NOT_FINITE
from pipeline.plant.kernel import address, array_at, integers_at, kernel, matrix_at
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
        # room: X (N, nx), free (N, n), J (2, N, n, n), A (n, n), u, still and pushed (n,)
        "X", "u", "still", "free", "pushed", "J", "A",
    )
]  # fmt: skip
"""Fields of the record of points."""

DONE, PLANT_FAILED, SINGULAR = range(3)
"""What `torques` ends with."""


@kernel
def place(m, q, qd, N, X):
    """X from q, qd (N, n)."""
    n, order = m.n, m.order
    positions, velocities, states = matrix_at(q, N, n), matrix_at(qd, N, n), matrix_at(X, N, m.x.shape[0])
    for g in range(N):
        for i in range(n):
            states[g, order[i]], states[g, order[n + i]] = velocities[g, i], positions[g, i]


@kernel
def begin(m, X, u, chi):
    """Set the input u (n,) and the parameters chi (p,), at the first of the points X."""
    point, ns, first, order = m.point, m.f.shape[0], array_at(X, m.x.shape[0]), m.order
    for i in range(ns):
        point[i] = first[order[i]]
    for i in range(m.p):
        point[ns + i] = array_at(chi, m.p)[i]
    for i in range(m.n):
        point[ns + m.p + i] = array_at(u, m.n)[i]
    return prepare(m, 0.0)


@kernel
def derive(m, qdd):
    """qdd (n,) where the FMU stands."""
    m.evaluations += 1
    order, dx, found, total = m.order, m.dx, array_at(qdd, m.n), 0.0
    if get_derivatives(m, address(dx), dx.shape[0]):
        return True
    for i in range(m.n):
        found[i] = dx[order[i]]
        total += found[i]
    return False if isfinite(total) else failed(m, DERIVATIVES, NOT_FINITE)


@kernel
def accelerate(m, X, N, u, chi, qdd):
    """qdd (N, n) at the points X, all with the input u (n,) and the parameters chi (p,)."""
    if begin(m, X, u, chi):
        return True
    for g in range(N):
        if set_states(m, X + 8 * g * m.x.shape[0], m.x.shape[0]) or derive(m, qdd + 8 * g * m.n):
            return True
    return False


@kernel
def push(m, u):
    """Set the input u (n,), the parameters that are fed with it staying as they are."""
    inputs, wanted = m.inputs, array_at(u, m.n)
    for i in range(m.n):
        inputs[i] = wanted[i]
    return set_values(m, INPUTS, m.input_vr, inputs.shape[0], address(inputs))


@kernel
def respond(m, w, chi, J):
    """w.free (N, n) = qdd without a force, J (N, n, n) = ∂qdd/∂tau: column j is what the input step[j] alone adds.

    Point by point: an FMU may keep what follows from its states alone.
    """
    n, N, nx = m.n, w.N, m.x.shape[0]
    step, force, u = array_at(w.step, n), array_at(w.force, n), array_at(w.u, n)
    pushed, free, J = array_at(w.pushed, n), matrix_at(w.free, N, n), matrix_at(J, N, n * n)
    if begin(m, w.X, w.still, chi):
        return True
    for g in range(N):
        if set_states(m, w.X + 8 * g * nx, nx) or push(m, w.still) or derive(m, w.free + 8 * g * n):
            return True
        for j in range(n):
            u[j] = step[j]
            if push(m, w.u) or derive(m, w.pushed):
                return True
            u[j] = 0.0
            for i in range(n):
                J[g, i * n + j] = (pushed[i] - free[g, i]) / force[j]
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
        if respond(m, w, chi, J) if own[c] else accelerate(m, w.X, w.N, w.still, chi, w.free):
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
