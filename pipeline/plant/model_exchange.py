"""A plant's derivatives and transitions by Model Exchange."""

from __future__ import annotations

from ctypes import byref, c_int

import numpy as np
from fmpy.fmi2 import fmi2EventInfo

from pipeline.errors import FmuError
from pipeline.plant.binding import Binding, check_binding
from pipeline.plant.fmu import Fmu, Instance
from pipeline.plant.references import References, double_p
from pipeline.plant.states import refuse_events, state_order


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
        refuse_events(file)
        self._order, self._nx = state_order(file, binding)
        self.instance = Instance(file, "ME", {**binding.start_values(), **settings})
        self._buffers()
        self._parameters = References(self.instance, [p.variable or p.name for p in binding.parameter])
        self._inputs = References(self.instance, [j.input for j in binding.joint])
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
        self._x_pointer, self._dx_pointer = (a.ctypes.data_as(double_p) for a in (self._x, self._dx))
        self._component, self._dll = self.instance.component, self.instance.dll
        self._set_states, self._get_derivatives = self._dll.fmi2SetContinuousStates, self._dll.fmi2GetDerivatives
        self._t = 0.0
