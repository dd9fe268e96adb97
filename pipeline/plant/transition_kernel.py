"""A plant's transition over a sample and its derivatives, compiled: the operations of Python's in their order.

(`model_exchange.py`, `restored_state.py`, identify's `jacobian.py`.) A kernel gets the plant's record, whose arrays
have the plant's own sizes: they are constants of the machine code. It starts from `point`, and returns whether it
failed.
"""

from __future__ import annotations

from pipeline.plant.fmi_kernel import (
    DERIVATIVES,
    INPUTS,
    INSTANCE,
    OUTPUTS,
    PARAMETERS,
    STARTS,
    STATES,
    STEP,
    complete_step,
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
from pipeline.plant.kernel import address, kernel

MODEL_EXCHANGE, RESTORED, RESET = range(3)
"""Kinds of transition: by derivatives; by a step from a restored FMU state; by a step after a reset."""


def plant_fields(n: int, ns: int, p: int, nx: int, tuned: int, fed: int) -> list[tuple]:
    """Fields of the record of a plant: n joints, ns states, p parameters; of the FMU nx states, and of its parameters
    so many that are tuned and that are fed as inputs.

    point: [s, chi, u] where the transition starts; f, J (ns + p + n, ns): the transition and its derivatives, a row for
    each place of point; inputs, parameters: what the FMU has; x, dx: its states and their derivatives, order: where
    those of s stand there; substeps: of RK4, 0 for Euler; columns: the places of point that are differenced;
    tuned, fed, known_column: those of the parameters, and of each known of the directional derivatives.
    """
    m, knowns = ns + p + n, ns + n + fed
    numbers = ("n", "p", "kind", "substeps", "completes", "snapshot", "evaluations", "n_settings", "n_columns")
    addresses = ("input_vr", "tuned_vr", "state_vr", "output_vr", "setting_vr", "settings", "unknown_vr", "known_vr")
    places = {"order": (ns,), "tuned": (tuned,), "fed": (fed,), "columns": (m,), "known_column": (knowns,)}
    real = {
        "point": (m,), "floor": (m,), "gain": (n,), "f": (ns,), "J": (m, ns), "inputs": (n + fed,),
        "parameters": (tuned,), "x": (nx,), "dx": (nx,), "k": (ns,), "total": (ns,), "stage": (ns,), "ahead": (ns,),
        "behind": (ns,), "seed": (1,),
        **{name: (knowns, ns) for name in ("tangents", "S", "S_stage", "S_total", "K")},
    }  # fmt: skip
    return [
        *INSTANCE,
        *((name, "i8") for name in (*numbers, *addresses)),
        ("t", "f8"),
        *((name, "u8", shape) for name, shape in places.items()),  # unsigned: no index counts from the end
        *((name, "f8", shape) for name, shape in real.items()),
    ]


@kernel
def _all_finite(values):
    """Whether no value is infinite or none: of those the difference from themselves is none."""
    finite = True
    for i in range(values.shape[0]):
        finite &= values[i] - values[i] == 0.0
    return finite


@kernel
def evaluate(m, s, ds):
    """ds (ns,) = derivatives at the states s (ns,), the FMU being at its time, parameters and inputs."""
    ns, x, dx, order = m.f.shape[0], m.x, m.dx, m.order
    for i in range(ns):
        x[order[i]] = s[i]
    m.evaluations += 1
    if set_states(m, address(x), x.shape[0]) or get_derivatives(m, address(dx), x.shape[0]):
        return True
    nothing = 0.0
    for i in range(ns):
        value = dx[order[i]]
        ds[i] = value
        nothing += value - value  # here: a wide load of what was just written entry by entry would have to wait
    return False if nothing == 0.0 else failed(m, DERIVATIVES, NOT_FINITE)


@kernel
def feed(m):
    """Set the inputs, those among the parameters with them, where they changed."""
    point, inputs, fed, changed = m.point, m.inputs, m.fed, False
    n = m.gain.shape[0]
    first = point.shape[0] - n
    for i in range(n):
        changed |= inputs[i] != point[first + i]
        inputs[i] = point[first + i]
    for i in range(fed.shape[0]):
        changed |= inputs[n + i] != point[fed[i]]
        inputs[n + i] = point[fed[i]]
    return changed and set_values(m, INPUTS, m.input_vr, inputs.shape[0], address(inputs))


@kernel
def tune(m):
    """Set the parameters that changed, in Event Mode (2.0.5, §3.2.1; 3.0.2, §3.2.1)."""
    point, has, tuned = m.point, m.parameters, m.tuned
    first, end = has.shape[0], 0
    for i in range(has.shape[0]):
        if has[i] != point[tuned[i]]:
            has[i] = point[tuned[i]]
            first, end = min(first, i), i + 1
    if end == 0:
        return False
    if enter_event_mode(m):
        return True
    if set_values(m, PARAMETERS, m.tuned_vr + 4 * first, end - first, address(has) + 8 * first):
        return True
    return settle(m)


@kernel
def _move_time(m, t):
    """Move the time to t (s), the states being there what m.point says: an integrator's step is complete."""
    x, order = m.x, m.order
    for i in range(order.shape[0]):
        x[order[i]] = m.point[i]
    m.t = t
    if set_time(m, t) or set_states(m, address(x), x.shape[0]):
        return True
    if not m.completes:
        return False
    failure, event = complete_step(m)
    return failure or (event and (enter_event_mode(m) or settle(m)))


@kernel
def prepare(m, t):
    """Set time, parameters and inputs to those of m.point, each where it changed (Model Exchange)."""
    if t != m.t and _move_time(m, t):
        return True
    return tune(m) or feed(m)


@kernel
def integrate(m, dt, result):
    """result (ns,) = the states dt (s) after m.point (Model Exchange): Euler (Eq. 13), or RK4 in sub-steps."""
    ns, point, k, total, stage = m.f.shape[0], m.point, m.k, m.total, m.stage
    if m.substeps == 0:
        if evaluate(m, point, k):
            return True
        for i in range(ns):
            result[i] = point[i] + dt * k[i]
        return False
    step = dt / m.substeps
    half, sixth = 0.5 * step, step / 6.0
    for i in range(ns):
        result[i] = point[i]
    for _ in range(m.substeps):
        for i in range(ns):
            total[i], stage[i] = 0.0, result[i]
        for part in range(4):
            if evaluate(m, stage, k):
                return True
            weight = 1.0 if part in (0, 3) else 2.0
            ahead = step if part == 2 else half
            for i in range(ns):
                total[i] += weight * k[i]
                stage[i] = result[i] + ahead * k[i]
        for i in range(ns):
            result[i] = result[i] + sixth * total[i]
    return False


@kernel
def _from_scratch(m, t):
    """Co-Simulation: an instance as before its initialisation, its settings made."""
    if m.kind == RESTORED:
        return restore(m, m.snapshot) or setup(m, t)
    return reset(m) or setup(m, t) or set_values(m, STARTS, m.setting_vr, m.n_settings, m.settings)


@kernel
def co_simulate(m, t, dt, result):
    """result (ns,) = the states after a Co-Simulation step from m.point (2.0.5, §2.1.8, §4.2.4)."""
    point, inputs, parameters, ns, n = m.point, m.inputs, m.parameters, m.f.shape[0], m.gain.shape[0]
    for i in range(parameters.shape[0]):
        parameters[i] = point[m.tuned[i]]
    for i in range(n):
        inputs[i] = point[point.shape[0] - n + i]
    for i in range(m.fed.shape[0]):
        inputs[n + i] = point[m.fed[i]]
    m.evaluations += 1
    if (
        _from_scratch(m, t)
        or set_values(m, STATES, m.state_vr, ns, address(point))
        or set_values(m, PARAMETERS, m.tuned_vr, parameters.shape[0], address(parameters))
        or enter_initialization(m, t)
        or set_values(m, INPUTS, m.input_vr, inputs.shape[0], address(inputs))
        or exit_initialization(m)
        or do_step(m, t, dt)
        or get_values(m, OUTPUTS, m.output_vr, ns, address(result))
    ):
        return True
    return False if _all_finite(result) else failed(m, STEP, NOT_FINITE)


@kernel
def transition(m, t, dt, result):
    """result (ns,) = the states dt (s) after those of m.point at t (s), the input held."""
    if m.kind != MODEL_EXCHANGE:
        return co_simulate(m, t, dt, result)
    return prepare(m, t) or integrate(m, dt, result)


@kernel
def transition_once(plant, t, dt):
    """`transition` to m.f, for a record (1,) of Python's."""
    m = plant[0]
    return transition(m, t, dt, m.f)
