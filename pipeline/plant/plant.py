"""A bound plant: derivatives, transitions over a sample, and their batches, computed by the FMU.

The state is s = [qd, q, h] (h hidden, possibly empty), the input u (n,), tau = gain·u, the parameters chi (p,).
Every way to compute a transition is one class with the same three methods; `open_plant` chooses by interface.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from ctypes import POINTER, byref, c_double, c_int, c_uint

import numpy as np
from fmpy.fmi2 import fmi2EventInfo

from pipeline.errors import ConfigError, FmuError
from pipeline.plant.binding import Binding, check_binding
from pipeline.plant.fmu import Fmu, Instance, open_fmu

_double_p = POINTER(c_double)


class _References:
    """Value references and a reused buffer: `set` writes an array into the FMU's variables, `get` reads them."""

    def __init__(self, instance: Instance, names: list[str]):
        file = instance.file
        self.n = len(names)
        self.vr = (c_uint * self.n)(*[file.reference(name) for name in names])
        self.buffer = np.zeros(self.n)
        self.pointer = self.buffer.ctypes.data_as(_double_p)
        self.component = instance.component
        self._set, self._get = instance.dll.fmi2SetReal, instance.dll.fmi2GetReal

    def set(self, values: np.ndarray) -> int:
        self.buffer[:] = values
        return self._set(self.component, self.vr, self.n, self.pointer)

    def get(self) -> int:
        return self._get(self.component, self.vr, self.n, self.pointer)


class ModelExchangePlant:
    """A plant by Model Exchange: parameters set in Event Mode, states in Continuous-Time Mode, derivatives read.

    (FMI 2.0.5, §2.2.7, §3.2.1.) The transition integrates by Euler (Eq. 13) or by RK4 in `substeps`, the input held
    and the time held at t for all of it, Jacobian columns included. `calls` counts evaluations of the derivatives.
    """

    interface = "ME"

    def __init__(self, file: Fmu, binding: Binding, settings: dict[str, float], method: str = "rk4", substeps: int = 4):
        check_binding(binding, file)
        self.binding, self.file, self.calls, self.n = binding, file, 0, binding.n
        self.method, self.substeps = method, substeps
        _refuse_events(file)
        self._order, self._nx = _state_order(file, binding)
        self.instance = Instance(file, "ME", {**binding.start_values(), **settings})
        self._buffers()
        self._parameters = _References(self.instance, [p.variable or p.name for p in binding.parameter])
        self._inputs = _References(self.instance, [j.input for j in binding.joint])
        self._chi = np.full(len(binding.parameter), np.nan)
        self._info = fmi2EventInfo()
        self._info_reference = byref(self._info)

    def __enter__(self) -> ModelExchangePlant:
        return self

    def __exit__(self, *exc) -> None:
        self.instance.__exit__(*exc)

    @property
    def ns(self) -> int:
        """Number of plant states, 2n."""
        return 2 * self.n

    def derivatives(self, s: np.ndarray, u: np.ndarray, chi: np.ndarray, t: float = 0.0) -> np.ndarray:
        """ds/dt (ns,) at state s (ns,), input u (n,), parameters chi (p,), time t (s)."""
        self._prepare(s, u, chi, t)
        return self._evaluate(s, t).copy()

    def transition(self, s: np.ndarray, u: np.ndarray, chi: np.ndarray, t: float, dt: float) -> np.ndarray:
        """The state (ns,) after dt (s) with u (n,) held. Raises FmuError where the FMU refuses or gives no number."""
        self._prepare(s, u, chi, t)
        if self.method == "euler":
            return s + dt * self._evaluate(s, t)
        return self._rk4(s, t, dt / self.substeps)

    def accelerations(self, q: np.ndarray, qd: np.ndarray, u: np.ndarray, chi: np.ndarray) -> np.ndarray:
        """qdd (N, n) at q, qd (N, n), all with the same input u (n,) and parameters chi (p,), at time 0."""
        states = np.concatenate([qd, q], axis=1)
        self._prepare(states[0], u, chi, 0.0)
        return np.array([self._evaluate(s, 0.0)[: self.n] for s in states])

    def _rk4(self, s: np.ndarray, t: float, step: float) -> np.ndarray:
        evaluate, half, sixth = self._evaluate, 0.5 * step, step / 6.0
        for _ in range(self.substeps):
            total = evaluate(s, t).copy()
            k2 = evaluate(s + half * total, t)
            total += 2.0 * k2
            k3 = evaluate(s + half * k2, t)
            total += 2.0 * k3
            total += evaluate(s + step * k3, t)
            s = s + sixth * total
        return s

    def _evaluate(self, s: np.ndarray, t: float) -> np.ndarray:
        """Derivatives in the seam's order, in a buffer that the next call overwrites."""
        self._x[self._order] = s
        status = self._set_states(self._component, self._x_pointer, self._nx)
        status = max(status, self._get_derivatives(self._component, self._dx_pointer, self._nx))
        self.calls += 1
        if status:
            self.instance.check(status, "fmi2GetDerivatives", t)
        derivative = self._dx[self._order]
        if not np.isfinite(derivative.sum()):
            raise FmuError(f"{self.file.path.name}: the derivatives at t = {t:g} s are not finite")
        return derivative

    def _prepare(self, s: np.ndarray, u: np.ndarray, chi: np.ndarray, t: float) -> None:
        """Set time, parameters (in Event Mode, only when they changed) and inputs; a new time completes a step."""
        status = 0 if t == self._t else self._complete_step(s, t)
        if not np.array_equal(chi, self._chi):
            status = max(status, self._tune(chi))
        status = max(status, self._inputs.set(u))
        if status:
            self._chi[:] = np.nan
            self.instance.check(status, "setting inputs and parameters", t)

    def _complete_step(self, s: np.ndarray, t: float) -> int:
        """Move the time to t, the state s (ns,) being what it is there (FMI 2.0.5, §3.2.1)."""
        self._x[self._order] = s
        status = self._dll.fmi2SetTime(self._component, t)
        status = max(status, self._set_states(self._component, self._x_pointer, self._nx))
        self._t = t
        if self.file.description.modelExchange.completedIntegratorStepNotNeeded:
            return status
        flags = (c_int(), c_int())
        status = max(status, self._dll.fmi2CompletedIntegratorStep(self._component, 0, *map(byref, flags)))
        if flags[1].value:
            raise FmuError(f"{self.file.path.name}: asks to terminate at t = {t:g} s{self.instance.last_message()}")
        if flags[0].value:
            self._chi[:] = np.nan  # Event Mode is entered by setting the parameters anew
        return status

    def _tune(self, chi: np.ndarray) -> int:
        dll, component = self._dll, self._component
        status = dll.fmi2EnterEventMode(component)
        status = max(status, self._parameters.set(chi))
        status = max(status, dll.fmi2NewDiscreteStates(component, self._info_reference))
        if self._info.terminateSimulation:
            raise FmuError(f"{self.file.path.name}: asks to terminate in Event Mode{self.instance.last_message()}")
        if self._info.newDiscreteStatesNeeded:
            self.instance.settle()
        status = max(status, dll.fmi2EnterContinuousTimeMode(component))
        self._chi[:] = chi
        return status

    def _buffers(self) -> None:
        """The arrays and raw calls of the hot loop, resolved once."""
        self._x, self._dx = np.zeros(self._nx), np.zeros(self._nx)
        self._x_pointer, self._dx_pointer = (a.ctypes.data_as(_double_p) for a in (self._x, self._dx))
        self._component, self._dll = self.instance.component, self.instance.dll
        self._set_states, self._get_derivatives = self._dll.fmi2SetContinuousStates, self._dll.fmi2GetDerivatives
        self._t = 0.0


def _state_order(file: Fmu, binding: Binding) -> tuple[np.ndarray, int]:
    """Where the continuous states of the FMU stand in [qd, q] (2n,), and their number. Hidden states are refused."""
    states = [d.variable.derivative for d in file.description.derivatives]
    index = {variable.name: i for i, variable in enumerate(states)}
    wanted = [j.velocity_state or j.velocity for j in binding.joint]
    wanted += [j.position_state or j.position for j in binding.joint]
    for name in wanted:
        if name not in index:
            raise FmuError(
                f"{file.path.name}: `{name}` is no continuous state; they are {', '.join(index)}: "
                "name one as position_state or velocity_state in the binding"
            )
    hidden = [name for name in index if name not in wanted]
    if hidden:
        raise FmuError(
            f"{file.path.name}: besides positions and velocities it has the states {', '.join(hidden)}; plants with "
            "hidden states are not handled yet: export one without them"
        )
    return np.array([index[name] for name in wanted]), len(states)


def _refuse_events(file: Fmu) -> None:
    """A relation keeps its branch between events (FMI 2.0.5, §3.1), so a state set by hand may be in the wrong one."""
    count = file.description.numberOfEventIndicators or 0
    if count:
        raise FmuError(
            f"{file.path.name}: {count} event indicators: its equations have branches that a filter cannot follow; "
            "write them smoothly, for example sign(qd) as tanh(qd/eps)"
        )


class CoSimulationPlant:
    """A plant by Co-Simulation: each transition restores the FMU state taken before initialisation.

    The standard's legal route for an imposed state (FMI 2.0.5, §2.1.8, §4.2.4): restore, start time t, set states
    and parameters, initialise, one step. There are no derivatives to read. `calls` counts steps.
    """

    interface = "CS"

    def __init__(self, file: Fmu, binding: Binding, settings: dict[str, float], method: str = "rk4", substeps: int = 4):
        check_binding(binding, file)
        _refuse_events(file)
        _state_order(file, binding)
        if file.supports("CS") and not file.description.coSimulation.canGetAndSetFMUstate:
            raise FmuError(f'{file.path.name}: cannot get and set its FMU state; use ekf.interface = "ME"')
        for joint in binding.joint:
            if not (joint.position_start and joint.velocity_start):
                raise ConfigError(
                    f"joint {joint.name}: Co-Simulation needs position_start and velocity_start in the binding"
                )
        self.binding, self.file, self.calls, self.n = binding, file, 0, binding.n
        self.instance = Instance(file, "CS")
        try:
            self._set_up({**binding.start_values(), **settings})
        except FmuError:
            self.instance.__exit__(None, None, None)
            raise

    def _set_up(self, start: dict[str, float]) -> None:
        """Resolve the variables, set the start values, and keep the FMU state of before initialisation."""
        joints, parameters = self.binding.joint, self.binding.parameter
        starts = [*(j.velocity_start for j in joints), *(j.position_start for j in joints)]
        self._start = _References(self.instance, starts)
        self._parameters = _References(self.instance, [p.variable or p.name for p in parameters])
        self._inputs = _References(self.instance, [j.input for j in joints])
        self._outputs = _References(self.instance, [*(j.velocity for j in joints), *(j.position for j in joints)])
        for name, value in start.items():
            self.instance.call("setReal", [self.file.reference(name)], [value])
        self._snapshot = self.instance.call("getFMUstate")

    def __enter__(self) -> CoSimulationPlant:
        return self

    def __exit__(self, *exc) -> None:
        self.instance.fmu.freeFMUstate(self._snapshot)
        self.instance.__exit__(*exc)

    @property
    def ns(self) -> int:
        """Number of plant states, 2n."""
        return 2 * self.n

    def transition(self, s: np.ndarray, u: np.ndarray, chi: np.ndarray, t: float, dt: float) -> np.ndarray:
        """The state (ns,) after dt (s) with u (n,) held. Raises FmuError where the FMU refuses or gives no number."""
        dll, component, check = self.instance.dll, self.instance.component, self.instance.check
        self.calls += 1
        check(dll.fmi2SetFMUstate(component, self._snapshot), "fmi2SetFMUstate", t)
        check(dll.fmi2SetupExperiment(component, 0, 0.0, t, 0, 0.0), "fmi2SetupExperiment", t)
        check(self._start.set(s), "setting the states", t)
        check(self._parameters.set(chi), "setting the parameters", t)
        check(dll.fmi2EnterInitializationMode(component), "fmi2EnterInitializationMode", t)
        check(self._inputs.set(u), "setting the inputs", t)
        check(dll.fmi2ExitInitializationMode(component), "fmi2ExitInitializationMode", t)
        check(dll.fmi2DoStep(component, t, dt, c_int(0)), "fmi2DoStep", t)
        check(self._outputs.get(), "fmi2GetReal", t)
        result = self._outputs.buffer.copy()
        if not np.isfinite(result.sum()):
            raise FmuError(f"{self.file.path.name}: the step at t = {t:g} s gave a value that is not finite")
        return result


@contextmanager
def open_plant(
    binding: Binding,
    use: str = "filter",
    interface: str = "ME",
    method: str = "rk4",
    substeps: int = 4,
) -> Iterator[ModelExchangePlant | CoSimulationPlant]:
    """Open the bound plant with the binding's values for `use`, "filter" or "probe"; it is freed on leaving."""
    kind = {"ME": ModelExchangePlant, "CS": CoSimulationPlant}[interface]
    settings = binding.filter if use == "filter" else binding.probe
    with open_fmu(binding.path) as file, kind(file, binding, settings, method, substeps) as plant:
        yield plant
