"""One FMU instance in compiled code: its functions by address, a kernel for each call, for both FMI versions.

Each kernel returns whether the call failed; then the record's `call` and `status` say which one, and how.
"""

from __future__ import annotations

from pipeline.plant.fmu import CHATTER, ITERATIONS, TERMINATE
from pipeline.plant.kernel import bytes_at, call, integers_at, kernel

FUNCTIONS = (
    "get", "set", "set_states", "get_derivatives", "set_time", "enter_event_mode", "update_discrete_states",
    "enter_continuous_time_mode", "completed_step", "setup", "enter_initialization", "exit_initialization", "do_step",
    "set_state", "reset", "directional",
)  # fmt: skip
"""The functions whose addresses a record holds, by the names of `Fmi2` and `Fmi3`."""

INSTANCE = [(name, "i8") for name in (*FUNCTIONS, "fmu", "fmi3", "flags", "call", "status")]
"""Fields of the record of an instance: fmu, its handle; fmi3, whether it is of FMI 3.0; flags, 32 bytes of its own."""

# What failed, by its place in CALLS. A capital: a function of the standard, without its prefix.
CALLS = (
    "", "setting the inputs", "setting the parameters", "setting the states", "setting the start values",
    "reading the outputs", "SetContinuousStates", "the derivatives", "SetTime", "EnterEventMode", "the event iteration",
    "EnterContinuousTimeMode", "CompletedIntegratorStep", "GetDirectionalDerivative", "SetFMUstate", "Reset",
    "SetupExperiment", "EnterInitializationMode", "ExitInitializationMode", "DoStep",
)  # fmt: skip
(
    _, INPUTS, PARAMETERS, STATES, STARTS, OUTPUTS, SET_STATES, DERIVATIVES, SET_TIME, EVENT_MODE, EVENT, CONTINUOUS,
    COMPLETED, DIRECTIONAL, RESTORE, RESET, SETUP, ENTER, EXIT, STEP,
) = range(len(CALLS))  # fmt: skip

DISCARD = 2


@kernel
def failed(i, what, status):
    """Note the call and its status, if it is not OK."""
    if status == 0:
        return False
    i.call = what
    i.status = status
    return True


@kernel
def _cleared(i):
    """The flags, all false."""
    words = integers_at(i.flags, 4)
    for k in range(4):
        words[k] = 0
    return bytes_at(i.flags, 32)


@kernel
def set_values(i, what, references, n, values):
    """Set the n variables whose value references and values stand at these addresses."""
    if n == 0:
        return False
    if i.fmi3:
        return failed(i, what, call(i.set, i.fmu, references, n, values, n))
    return failed(i, what, call(i.set, i.fmu, references, n, values))


@kernel
def get_values(i, what, references, n, values):
    """Read n variables."""
    if i.fmi3:
        return failed(i, what, call(i.get, i.fmu, references, n, values, n))
    return failed(i, what, call(i.get, i.fmu, references, n, values))


@kernel
def set_states(i, x, n):
    """Set all n continuous states."""
    return failed(i, SET_STATES, call(i.set_states, i.fmu, x, n))


@kernel
def get_derivatives(i, dx, n):
    """Read the derivatives of all n continuous states."""
    return failed(i, DERIVATIVES, call(i.get_derivatives, i.fmu, dx, n))


@kernel
def set_time(i, t):
    """Set the time (s)."""
    return failed(i, SET_TIME, call(i.set_time, i.fmu, t))


@kernel
def complete_step(i):
    """End a step of the integrator: (failed, whether Event Mode is wanted)."""
    flags = _cleared(i)
    status = call(i.completed_step, i.fmu, 0, i.flags, i.flags + 4)
    if failed(i, COMPLETED, status) or failed(i, COMPLETED, TERMINATE * (flags[4] != 0)):
        return True, False
    return False, flags[0] != 0


@kernel
def enter_event_mode(i):
    """Continuous-Time Mode → Event Mode."""
    return failed(i, EVENT_MODE, call(i.enter_event_mode, i.fmu))


@kernel
def settle(i):
    """In Event Mode: iterate until no discrete state changes, then on to Continuous-Time Mode."""
    f = i.flags
    for _ in range(ITERATIONS):
        flags = _cleared(i)
        if i.fmi3:  # each flag where the struct of FMI 2.0 has it
            status = call(i.update_discrete_states, i.fmu, f, f + 4, f + 8, f + 12, f + 16, f + 24)
        else:
            status = call(i.update_discrete_states, i.fmu, f)
        if failed(i, EVENT, status) or failed(i, EVENT, TERMINATE * (flags[4] != 0)):
            return True
        if flags[0] == 0:
            return failed(i, CONTINUOUS, call(i.enter_continuous_time_mode, i.fmu))
    return failed(i, EVENT, CHATTER)


@kernel
def restore(i, state):
    """Restore an FMU state."""
    return failed(i, RESTORE, call(i.set_state, i.fmu, state))


@kernel
def reset(i):
    """Back to Instantiated, as after the instantiation."""
    return failed(i, RESET, call(i.reset, i.fmu))


@kernel
def setup(i, t):
    """Before initialisation: the run starts at t (s). In FMI 3.0 that comes with the initialisation."""
    if i.fmi3:
        return False
    return failed(i, SETUP, call(i.setup, i.fmu, 0, 0.0, t, 0, 0.0))


@kernel
def enter_initialization(i, t):
    """Instantiated → Initialization Mode at t (s)."""
    if i.fmi3:
        return failed(i, ENTER, call(i.enter_initialization, i.fmu, 0, 0.0, t, 0, 0.0))
    return failed(i, ENTER, call(i.enter_initialization, i.fmu))


@kernel
def exit_initialization(i):
    """Initialization Mode → Event Mode, or ready to step."""
    return failed(i, EXIT, call(i.exit_initialization, i.fmu))


@kernel
def do_step(i, t, dt):
    """A Co-Simulation step from t to t + dt (s); one that ends early counts as Discard, as in FMI 2.0."""
    if not i.fmi3:
        return failed(i, STEP, call(i.do_step, i.fmu, t, dt, 0))
    flags, f = _cleared(i), i.flags
    status = call(i.do_step, i.fmu, t, dt, 0, f, f + 4, f + 8, f + 24)
    if failed(i, STEP, status):
        return True
    return failed(i, STEP, DISCARD * (flags[4] != 0 or flags[8] != 0))


@kernel
def directional(i, unknowns, n, knowns, m, seed, result):
    """result (n,) = ∂unknowns/∂knowns · seed (m,), all by address (2.0.5, §2.1.9; 3.0.2, §2.2.11)."""
    if i.fmi3:
        status = call(i.directional, i.fmu, unknowns, n, knowns, m, seed, m, result, n)
    else:
        status = call(i.directional, i.fmu, unknowns, n, knowns, m, seed, result)
    return failed(i, DIRECTIONAL, status)
