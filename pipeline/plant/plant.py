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
        self.binding, self.file, self.calls = binding, file, 0
        self.n, self.h = binding.n, 0
        self.method, self.substeps = method, substeps
        self.instance = Instance(file, "ME")
        self.instance.initialize({**binding.start_values(), **settings})
        self._states()
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
        """Number of plant states, 2n + h."""
        return 2 * self.n + self.h

    def derivatives(self, s: np.ndarray, u: np.ndarray, chi: np.ndarray, t: float = 0.0) -> np.ndarray:
        """ds/dt (ns,) at state s (ns,), input u (n,), parameters chi (p,), time t (s)."""
        self._prepare(u, chi, t)
        return self._evaluate(s, t).copy()

    def transition(self, s: np.ndarray, u: np.ndarray, chi: np.ndarray, t: float, dt: float) -> np.ndarray:
        """The state (ns,) after dt (s) with u (n,) held. Raises FmuError where the FMU refuses or gives no number."""
        self._prepare(u, chi, t)
        if self.method == "euler":
            return s + dt * self._evaluate(s, t)
        return self._rk4(s, t, dt / self.substeps)

    def accelerations(self, q: np.ndarray, qd: np.ndarray, u: np.ndarray, chi: np.ndarray) -> np.ndarray:
        """qdd (N, n) at q, qd (N, n), all with the same input u (n,) and parameters chi (p,), at time 0."""
        self._prepare(u, chi, 0.0)
        states = np.concatenate([qd, q], axis=1)
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

    def _prepare(self, u: np.ndarray, chi: np.ndarray, t: float) -> None:
        """Set time, parameters (in Event Mode, only when they changed) and inputs."""
        status = self._dll.fmi2SetTime(self._component, t)
        if not np.array_equal(chi, self._chi):
            status = max(status, self._tune(chi))
        status = max(status, self._inputs.set(u))
        if status:
            self._chi[:] = np.nan
            self.instance.check(status, "setting inputs and parameters", t)

    def _tune(self, chi: np.ndarray) -> int:
        dll, component = self._dll, self._component
        status = dll.fmi2EnterEventMode(component)
        status = max(status, self._parameters.set(chi))
        status = max(status, dll.fmi2NewDiscreteStates(component, self._info_reference))
        if self._info.newDiscreteStatesNeeded:
            self.instance.settle()
        status = max(status, dll.fmi2EnterContinuousTimeMode(component))
        self._chi[:] = chi
        return status

    def _states(self) -> None:
        """Resolve which continuous states are [qd, q, h], and the raw calls of the hot loop."""
        states = [d.variable.derivative for d in self.file.description.derivatives]
        index = {variable.name: i for i, variable in enumerate(states)}
        wanted = [j.velocity_state or j.velocity for j in self.binding.joint]
        wanted += [j.position_state or j.position for j in self.binding.joint]
        for name in wanted:
            if name not in index:
                raise FmuError(
                    f"{self.file.path.name}: `{name}` is no continuous state; they are {', '.join(index)}: "
                    "name one as position_state or velocity_state in the binding"
                )
        hidden = [name for name in index if name not in wanted]
        self.h, self._nx = len(hidden), len(states)
        self._order = np.array([index[name] for name in wanted + hidden])
        self._x, self._dx = np.zeros(self._nx), np.zeros(self._nx)
        self._x_pointer, self._dx_pointer = (a.ctypes.data_as(_double_p) for a in (self._x, self._dx))
        self._component, self._dll = self.instance.component, self.instance.dll
        self._set_states, self._get_derivatives = self._dll.fmi2SetContinuousStates, self._dll.fmi2GetDerivatives


class CoSimulationPlant:
    """A plant by Co-Simulation: each transition restores the FMU state taken before initialisation.

    The standard's legal route for an imposed state (FMI 2.0.5, §2.1.8, §4.2.4): restore, start time t, set states
    and parameters, initialise, one step. There are no derivatives to read. `calls` counts steps.
    """

    interface = "CS"

    def __init__(self, file: Fmu, binding: Binding, settings: dict[str, float], method: str = "rk4", substeps: int = 4):
        check_binding(binding, file)
        if not file.description.coSimulation or not file.description.coSimulation.canGetAndSetFMUstate:
            raise FmuError(f'{file.path.name}: cannot get and set its FMU state; use ekf.interface = "ME"')
        for joint in binding.joint:
            if not (joint.position_start and joint.velocity_start):
                raise ConfigError(
                    f"joint {joint.name}: Co-Simulation needs position_start and velocity_start in the binding"
                )
        self.binding, self.file, self.calls = binding, file, 0
        self.n, self.h = binding.n, 0
        self.instance = Instance(file, "CS")
        joints, parameters = binding.joint, binding.parameter
        self._start = _References(
            self.instance, [*(j.velocity_start for j in joints), *(j.position_start for j in joints)]
        )
        self._parameters = _References(self.instance, [p.variable or p.name for p in parameters])
        self._inputs = _References(self.instance, [j.input for j in joints])
        self._outputs = _References(self.instance, [*(j.velocity for j in joints), *(j.position for j in joints)])
        for name, value in {**binding.start_values(), **settings}.items():
            self.instance.call("setReal", [file.reference(name)], [value])
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
        dll, component = self.instance.dll, self.instance.component
        status = max(
            dll.fmi2SetFMUstate(component, self._snapshot),
            dll.fmi2SetupExperiment(component, 0, 0.0, t, 0, 0.0),
            self._start.set(s),
            self._parameters.set(chi),
            dll.fmi2EnterInitializationMode(component),
            self._inputs.set(u),
            dll.fmi2ExitInitializationMode(component),
            dll.fmi2DoStep(component, t, dt, c_int(0)),
            self._outputs.get(),
        )
        self.calls += 1
        if status:
            self.instance.check(status, "a step from a restored FMU state", t)
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
