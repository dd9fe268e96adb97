"""The transition's derivatives, compiled: by differences, or by the FMU's directional derivatives."""

from __future__ import annotations

from math import isfinite

from pipeline.plant.fmi_kernel import DIRECTIONAL, directional, failed
from pipeline.plant.fmu import NOT_FINITE
from pipeline.plant.kernel import address, kernel
from pipeline.plant.transition_kernel import (
    MODEL_EXCHANGE,
    co_simulate,
    evaluate,
    feed,
    integrate,
    prepare,
    transition,
    tune,
)

DIFFERENCES, DIRECTIONAL_DERIVATIVES = range(2)


@kernel
def _moved(m, column, there, t, dt, result):
    """The transition with one place of m.point moved; the FMU stands at m.point but for what the last move left."""
    point, ns = m.point, m.f.shape[0]
    kept = point[column]
    point[column] = there
    if m.kind != MODEL_EXCHANGE:
        failure = co_simulate(m, t, dt, result)
    else:  # of states the FMU is told in any case, and they are moved before it was told anything else
        failure = (column >= ns and (tune(m) or feed(m))) or integrate(m, dt, result)
    point[column] = kept
    return failure


@kernel
def _difference(m, column, t, dt, epsilon, central):
    """A row of m.J: the difference quotient of the transition by one place of m.point."""
    here, ahead, behind, f, ns = m.point[column], m.ahead, m.behind, m.f, m.f.shape[0]
    step = epsilon * max(abs(here), m.floor[column])
    high = here + step
    if _moved(m, column, high, t, dt, ahead):
        return True
    if central:
        low = here - step
        if _moved(m, column, low, t, dt, behind):
            return True
        rate = 1.0 / (high - low)  # the step that was taken, not the one asked for: the rest is rounding
        for i in range(ns):
            m.J[column, i] = (ahead[i] - behind[i]) * rate
        return False
    rate = 1.0 / (high - here)
    for i in range(ns):
        m.J[column, i] = (ahead[i] - f[i]) * rate
    return False


@kernel
def linearise(m, t, dt, mode, epsilon, central):
    """m.f and m.J, the transition from m.point at t (s) over dt (s) and its derivatives.

    mode: DIFFERENCES of all, forward (epsilon, relative) or central; or DIRECTIONAL_DERIVATIVES, with forward
    differences for the parameters that are no inputs. Rows that are not in m.columns are those of the identity.
    """
    exact = mode == DIRECTIONAL_DERIVATIVES
    if exact:
        if sensitivity(m, t, dt):
            return True
    elif transition(m, t, dt, m.f):
        return True
    for i in range(m.n_columns):
        if exact and not _only_by_difference(m, m.columns[i]):
            continue
        if _difference(m, m.columns[i], t, dt, epsilon, central):
            return True
    return False


@kernel
def _only_by_difference(m, column):
    """Whether a place of m.point is a parameter that is no input."""
    for i in range(m.known_column.shape[0]):
        if m.known_column[i] == column:
            return False
    return True


@kernel
def sensitivity(m, t, dt):
    """m.f (Model Exchange) and the rows of m.J by state, input and fed parameters, exactly.

    The same steps as the transition, differentiated: each stage takes the FMU's directional derivatives along.
    """
    if prepare(m, t):
        return True
    f, point, k, total, stage, S, K = m.f, m.point, m.k, m.total, m.stage, m.S, m.K
    knowns, ns = S.shape
    for i in range(ns):
        f[i] = point[i]
    for j in range(knowns):
        for i in range(ns):
            S[j, i] = 1.0 if i == j else 0.0
    if m.substeps == 0:
        if _tangent_stage(m, f, S):
            return True
        for i in range(ns):
            f[i] += dt * k[i]
        _add(S, dt, K)
    else:
        step = dt / m.substeps
        for _ in range(m.substeps):
            for i in range(ns):
                total[i], stage[i] = 0.0, f[i]
            for j in range(knowns):
                for i in range(ns):
                    m.S_total[j, i], m.S_stage[j, i] = 0.0, S[j, i]
            for part in range(4):
                if _tangent_stage(m, stage, m.S_stage):
                    return True
                weight = 1.0 if part in (0, 3) else 2.0
                ahead = step if part == 2 else 0.5 * step
                for i in range(ns):
                    total[i] += weight * k[i]
                    stage[i] = f[i] + ahead * k[i]
                _add(m.S_total, weight, K)
                _set(m.S_stage, S, ahead, K)
            for i in range(ns):
                f[i] += step / 6.0 * total[i]
            _add(S, step / 6.0, m.S_total)
    for j in range(knowns):
        for i in range(ns):
            m.J[m.known_column[j], i] = S[j, i]
    return False


@kernel
def _add(S, factor, K):
    """S += factor K."""
    for j in range(S.shape[0]):
        for i in range(S.shape[1]):
            S[j, i] += factor * K[j, i]


@kernel
def _set(result, S, factor, K):
    """result = S + factor K."""
    for j in range(S.shape[0]):
        for i in range(S.shape[1]):
            result[j, i] = S[j, i] + factor * K[j, i]


@kernel
def _tangent_stage(m, s, S):
    """m.k = the derivatives at s, and m.K their derivatives along S (knowns, ns)."""
    if evaluate(m, s, m.k):
        return True
    J, K = m.tangents, m.K
    knowns, ns = J.shape
    for j in range(knowns):
        if directional(m, m.unknown_vr, ns, m.known_vr + 4 * j, 1, address(m.seed), address(J) + 8 * j * ns):
            return True
        for i in range(ns):
            if not isfinite(J[j, i]):
                return failed(m, DIRECTIONAL, NOT_FINITE)
    m.evaluations += knowns
    for j in range(knowns):
        for i in range(ns):
            K[j, i] = 0.0
        for a in range(ns):
            for i in range(ns):
                K[j, i] += S[j, a] * J[a, i]
        if j >= ns:
            for i in range(ns):
                K[j, i] += J[j, i]
    return False


@kernel
def linearise_once(plant, t, dt, mode, epsilon, central):
    """`linearise` for a record (1,) of Python's."""
    return linearise(plant[0], t, dt, mode, epsilon, central)
