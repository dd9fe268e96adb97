"""A plant's transition over a sample and its derivatives, compiled: the same operations in the same order as in Python.

(`model_exchange.py`, `restored_state.py`, identify's `jacobian.py`.) A kernel gets the plant's record and addresses of
doubles, and returns whether it failed: see `fmi_kernel.py`.
"""

from __future__ import annotations

from math import isfinite

from pipeline.plant.fmi_kernel import (
    DERIVATIVES,
    DIRECTIONAL,
    INPUTS,
    INSTANCE,
    OUTPUTS,
    PARAMETERS,
    STARTS,
    STATES,
    STEP,
    complete_step,
    directional,
    do_step,
    enter_event_mode,
    enter_initialization,
    exit_initialization,
    failed,
    get_derivatives,
    get_values,
    reset,
    restore,
    set_states,
    set_time,
    set_values,
    settle,
    setup,
)
from pipeline.plant.fmu import NOT_FINITE
from pipeline.plant.kernel import array_at, integers_at, kernel, matrix_at

MODEL_EXCHANGE, RESTORED, RESET = range(3)
"""Kinds of transition: by derivatives; by a step from a restored FMU state; by a step after a reset."""

DIFFERENCES, DIRECTIONAL_DERIVATIVES = range(2)

PLANT = [
    *INSTANCE,
    *((name, "i8") for name in (
        "kind", "n", "ns", "p", "nx", "substeps", "completes", "snapshot", "evaluations",
        "n_inputs", "n_tuned", "n_fed", "n_settings", "n_knowns", "n_columns",
        # value references, and places in chi or in the FMU's states
        "input_vr", "tuned_vr", "state_vr", "setting_vr", "output_vr", "unknown_vr", "known_vr",
        "order", "tuned", "fed", "columns", "known_column",
        # doubles: what the FMU was last given, and room to work in
        "inputs", "parameters", "settings", "x", "dx", "k", "total", "stage", "seed", "point", "floor",
        "ahead", "behind", "tangents", "S", "S_stage", "S_total", "K",
    )),
    ("t", "f8"),
]  # fmt: skip
"""Fields of the record of a plant. substeps: of RK4, 0 for Euler; columns: the places in [s, chi, u] that make a
difference; known_column: the place of each known of the directional derivatives there."""


@kernel
def _finite(values, n):
    for i in range(n):
        if not isfinite(values[i]):
            return False
    return True


@kernel
def evaluate(m, s, ds):
    """ds (ns,) = derivatives at the states s (ns,), the FMU being at its time, parameters and inputs."""
    from_, to, x, dx = array_at(s, m.ns), array_at(ds, m.ns), array_at(m.x, m.nx), array_at(m.dx, m.nx)
    order = integers_at(m.order, m.ns)
    for i in range(m.ns):
        x[order[i]] = from_[i]
    m.evaluations += 1
    if set_states(m, m.x, m.nx) or get_derivatives(m, m.dx, m.nx):
        return True
    for i in range(m.ns):
        to[i] = dx[order[i]]
    return False if _finite(to, m.ns) else failed(m, DERIVATIVES, NOT_FINITE)


@kernel
def _feed(m, u, chi):
    """Set the inputs, those among the parameters with them, where they changed."""
    inputs, joint, parameters, fed = array_at(m.inputs, m.n_inputs), array_at(u, m.n), array_at(chi, m.p), m.fed
    places, changed = integers_at(fed, m.n_fed), False
    for i in range(m.n):
        changed |= inputs[i] != joint[i]
        inputs[i] = joint[i]
    for i in range(m.n_fed):
        changed |= inputs[m.n + i] != parameters[places[i]]
        inputs[m.n + i] = parameters[places[i]]
    if changed and set_values(m, INPUTS, m.input_vr, m.n_inputs, m.inputs):
        inputs[0] = float("nan")  # nobody knows what the FMU has
        return True
    return False


@kernel
def _tune(m, chi):
    """Set the parameters that changed, in Event Mode (2.0.5, §3.2.1; 3.0.2, §3.2.1)."""
    has, wanted, places = array_at(m.parameters, m.n_tuned), array_at(chi, m.p), integers_at(m.tuned, m.n_tuned)
    first, end = m.n_tuned, 0
    for i in range(m.n_tuned):
        if has[i] != wanted[places[i]]:
            has[i] = wanted[places[i]]
            first, end = min(first, i), i + 1
    if end == 0:
        return False
    if enter_event_mode(m):
        return True
    if set_values(m, PARAMETERS, m.tuned_vr + 4 * first, end - first, m.parameters + 8 * first):
        return True
    return settle(m)


@kernel
def _move_time(m, s, t):
    """Move the time to t (s), the states s (ns,) being what they are there: an integrator's step is complete."""
    from_, x, order = array_at(s, m.ns), array_at(m.x, m.nx), integers_at(m.order, m.ns)
    for i in range(m.ns):
        x[order[i]] = from_[i]
    m.t = t
    if set_time(m, t) or set_states(m, m.x, m.nx):
        return True
    if not m.completes:
        return False
    failure, event = complete_step(m)
    return failure or (event and (enter_event_mode(m) or settle(m)))


@kernel
def prepare(m, s, u, chi, t):
    """Set time, parameters and inputs, each where it changed."""
    if t != m.t and _move_time(m, s, t):
        return True
    return _tune(m, chi) or _feed(m, u, chi)


@kernel
def _integrate(m, s, dt, result):
    """result = the states dt (s) after s (Model Exchange): Euler (Eq. 13), or RK4 in sub-steps; result may be s."""
    x, k = array_at(result, m.ns), array_at(m.k, m.ns)
    start, total, stage = array_at(s, m.ns), array_at(m.total, m.ns), array_at(m.stage, m.ns)
    if m.substeps == 0:
        if evaluate(m, s, m.k):
            return True
        for i in range(m.ns):
            x[i] = start[i] + dt * k[i]
        return False
    step = dt / m.substeps
    half, sixth = 0.5 * step, step / 6.0
    for i in range(m.ns):
        x[i] = start[i]
    for _ in range(m.substeps):
        if evaluate(m, result, m.total):
            return True
        for i in range(m.ns):
            stage[i] = x[i] + half * total[i]
        if evaluate(m, m.stage, m.k):
            return True
        for i in range(m.ns):
            total[i] += 2.0 * k[i]
            stage[i] = x[i] + half * k[i]
        if evaluate(m, m.stage, m.k):
            return True
        for i in range(m.ns):
            total[i] += 2.0 * k[i]
            stage[i] = x[i] + step * k[i]
        if evaluate(m, m.stage, m.k):
            return True
        for i in range(m.ns):
            total[i] += k[i]
            x[i] = x[i] + sixth * total[i]
    return False


@kernel
def _from_scratch(m, t):
    """Co-Simulation: an instance as before its initialisation, its settings made."""
    if m.kind == RESTORED:
        if restore(m, m.snapshot):
            return True
        return setup(m, t)
    if reset(m) or setup(m, t):
        return True
    return set_values(m, STARTS, m.setting_vr, m.n_settings, m.settings)


@kernel
def _co_simulate(m, s, u, chi, t, dt, result):
    """result = the states after a Co-Simulation step from s (2.0.5, §2.1.8, §4.2.4)."""
    parameters, inputs = array_at(m.parameters, m.n_tuned), array_at(m.inputs, m.n_inputs)
    wanted, tuned, fed = array_at(chi, m.p), integers_at(m.tuned, m.n_tuned), integers_at(m.fed, m.n_fed)
    for i in range(m.n_tuned):
        parameters[i] = wanted[tuned[i]]
    for i in range(m.n):
        inputs[i] = array_at(u, m.n)[i]
    for i in range(m.n_fed):
        inputs[m.n + i] = wanted[fed[i]]
    m.evaluations += 1
    if (
        _from_scratch(m, t)
        or set_values(m, STATES, m.state_vr, m.ns, s)
        or set_values(m, PARAMETERS, m.tuned_vr, m.n_tuned, m.parameters)
        or enter_initialization(m, t)
        or set_values(m, INPUTS, m.input_vr, m.n_inputs, m.inputs)
        or exit_initialization(m)
        or do_step(m, t, dt)
        or get_values(m, OUTPUTS, m.output_vr, m.ns, result)
    ):
        return True
    return False if _finite(array_at(result, m.ns), m.ns) else failed(m, STEP, NOT_FINITE)


@kernel
def transition(m, s, u, chi, t, dt, result):
    """result (ns,) = the states dt (s) after s (ns,) at t (s) with the input u (n,) held, parameters chi (p,)."""
    if m.kind != MODEL_EXCHANGE:
        return _co_simulate(m, s, u, chi, t, dt, result)
    return prepare(m, s, u, chi, t) or _integrate(m, s, dt, result)


@kernel
def _moved(m, column, by, t, dt, result):
    """The transition with one place of m.point moved: whether it failed, and where that place was."""
    point, chi, u = array_at(m.point, m.ns + m.p + m.n), m.point + 8 * m.ns, m.point + 8 * (m.ns + m.p)
    kept = point[column]
    there = kept + by
    point[column] = there
    failure = transition(m, m.point, u, chi, t, dt, result)
    point[column] = kept
    return failure, there


@kernel
def _difference(m, column, t, dt, epsilon, central, f, J):
    """Row `column` of J: the difference quotient of the transition by one place of m.point."""
    here = array_at(m.point, m.ns + m.p + m.n)[column]
    step = epsilon * max(abs(here), array_at(m.floor, m.ns + m.p + m.n)[column])
    failure, high = _moved(m, column, step, t, dt, m.ahead)
    if failure:
        return True
    low, base = here, f
    if central:
        failure, low = _moved(m, column, -step, t, dt, m.behind)
        base = m.behind
        if failure:
            return True
    ahead, behind, row = array_at(m.ahead, m.ns), array_at(base, m.ns), array_at(J + 8 * column * m.ns, m.ns)
    for i in range(m.ns):
        row[i] = (ahead[i] - behind[i]) / (high - low)  # the step that was taken: the rest is rounding
    return False


@kernel
def _clear(m, J):
    """J (ns + p + n, ns) of a plant that does nothing: the states stay."""
    J = matrix_at(J, m.ns + m.p + m.n, m.ns)
    for j in range(m.ns + m.p + m.n):
        for i in range(m.ns):
            J[j, i] = 1.0 if i == j else 0.0


@kernel
def linearise(m, s, u, chi, t, dt, mode, epsilon, central, f, J):
    """f (ns,) = the transition, and J (ns + p + n, ns) its derivatives, a row for each of [s, chi, u].

    mode: DIFFERENCES of all, forward (epsilon, relative) or central; or DIRECTIONAL_DERIVATIVES, with forward
    differences for the parameters that are no inputs. Rows that are not in m.columns are those of the identity.
    """
    point = array_at(m.point, m.ns + m.p + m.n)
    for i in range(m.ns):
        point[i] = array_at(s, m.ns)[i]
    for i in range(m.p):
        point[m.ns + i] = array_at(chi, m.p)[i]
    for i in range(m.n):
        point[m.ns + m.p + i] = array_at(u, m.n)[i]
    _clear(m, J)
    exact = mode == DIRECTIONAL_DERIVATIVES
    if exact:
        if sensitivity(m, s, u, chi, t, dt, f, J):
            return True
    elif transition(m, s, u, chi, t, dt, f):
        return True
    columns = integers_at(m.columns, m.n_columns)
    for i in range(m.n_columns):
        if exact and not _only_by_difference(m, columns[i]):
            continue
        if _difference(m, columns[i], t, dt, epsilon, central, f, J):
            return True
    return False


@kernel
def _only_by_difference(m, column):
    """Whether a place of [s, chi, u] is a parameter that is no input."""
    known = integers_at(m.known_column, m.n_knowns)
    for i in range(m.n_knowns):
        if known[i] == column:
            return False
    return True


@kernel
def sensitivity(m, s, u, chi, t, dt, f, J):
    """f = the transition (Model Exchange) and the rows of J by state, input and fed parameters, exactly.

    The same steps as the transition, differentiated: each stage takes the FMU's directional derivatives along.
    """
    if prepare(m, s, u, chi, t):
        return True
    x, k, total, stage = array_at(f, m.ns), array_at(m.k, m.ns), array_at(m.total, m.ns), array_at(m.stage, m.ns)
    c = m.n_knowns
    S, K = matrix_at(m.S, c, m.ns), matrix_at(m.K, c, m.ns)
    S_stage, S_total = matrix_at(m.S_stage, c, m.ns), matrix_at(m.S_total, c, m.ns)
    for i in range(m.ns):
        x[i] = array_at(s, m.ns)[i]
    for j in range(c):
        for i in range(m.ns):
            S[j, i] = 1.0 if i == j else 0.0
    if m.substeps == 0:
        if _tangent_stage(m, f, m.S, m.k):
            return True
        for i in range(m.ns):
            x[i] += dt * k[i]
        for j in range(c):
            for i in range(m.ns):
                S[j, i] += dt * K[j, i]
        _spread(m, J)
        return False
    step = dt / m.substeps
    for _ in range(m.substeps):
        for i in range(m.ns):
            total[i], stage[i] = 0.0, x[i]
        for j in range(c):
            for i in range(m.ns):
                S_total[j, i], S_stage[j, i] = 0.0, S[j, i]
        for part in range(4):
            weight = 1.0 if part in (0, 3) else 2.0
            ahead = step if part == 2 else 0.5 * step
            if _tangent_stage(m, m.stage, m.S_stage, m.k):
                return True
            for i in range(m.ns):
                total[i] += weight * k[i]
                stage[i] = x[i] + ahead * k[i]
            for j in range(c):
                for i in range(m.ns):
                    S_total[j, i] += weight * K[j, i]
                    S_stage[j, i] = S[j, i] + ahead * K[j, i]
        for i in range(m.ns):
            x[i] += step / 6.0 * total[i]
        for j in range(c):
            for i in range(m.ns):
                S[j, i] += step / 6.0 * S_total[j, i]
    _spread(m, J)
    return False


@kernel
def _tangent_stage(m, s, S, ds):
    """ds = the derivatives at s, and m.K their derivatives along S (knowns, ns)."""
    if evaluate(m, s, ds):
        return True
    c = m.n_knowns
    J, S, K = matrix_at(m.tangents, c, m.ns), matrix_at(S, c, m.ns), matrix_at(m.K, c, m.ns)
    for j in range(c):
        if directional(m, m.unknown_vr, m.ns, m.known_vr + 4 * j, 1, m.seed, m.tangents + 8 * j * m.ns):
            return True
        if not _finite(array_at(m.tangents + 8 * j * m.ns, m.ns), m.ns):
            return failed(m, DIRECTIONAL, NOT_FINITE)
    m.evaluations += c
    for j in range(c):
        for i in range(m.ns):
            K[j, i] = 0.0
        for a in range(m.ns):
            for i in range(m.ns):
                K[j, i] += S[j, a] * J[a, i]
        for i in range(m.ns):
            K[j, i] += J[j, i] if j >= m.ns else 0.0
    return False


@kernel
def _spread(m, J):
    """The rows of m.S to their places in J."""
    J, S = matrix_at(J, m.ns + m.p + m.n, m.ns), matrix_at(m.S, m.n_knowns, m.ns)
    places = integers_at(m.known_column, m.n_knowns)
    for j in range(m.n_knowns):
        for i in range(m.ns):
            J[places[j], i] = S[j, i]


@kernel
def transition_once(plant, s, u, chi, t, dt, result):
    """`transition` for a record (1,) of Python's."""
    return transition(plant[0], s, u, chi, t, dt, result)


@kernel
def linearise_once(plant, s, u, chi, t, dt, mode, epsilon, central, f, J):
    """`linearise` for a record (1,) of Python's."""
    return linearise(plant[0], s, u, chi, t, dt, mode, epsilon, central, f, J)
