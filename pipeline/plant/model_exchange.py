"""A plant's derivatives and transitions by Model Exchange."""

from __future__ import annotations

import numpy as np

from pipeline.in_order import product
from pipeline.plant.binding import Binding, check_binding
from pipeline.plant.fmu import NOT_FINITE, TERMINATE, Fmu, Instance
from pipeline.plant.references import References, double_p, tuned_and_fed
from pipeline.plant.states import influential, refuse_events, state_order, states_of
from pipeline.plant.tangents import Sensitivity, Tangents


class ModelExchangePlant:
    """A plant by Model Exchange: parameters set in Event Mode, states in Continuous-Time Mode, derivatives read.

    (FMI 2.0.5, §2.2.7, §3.2.1; 3.0.2, §2.3.2, §3.2.1.) The transition integrates by Euler (Eq. 13) or by RK4 in
    `substeps`, the input held and the time held at t for all of it, Jacobian columns included. Parameters that are
    inputs of the FMU are set beside the plant's input. `calls` counts evaluations of derivatives, directional ones too.
    """

    interface, compiled = "ME", False

    def __init__(self, file: Fmu, binding: Binding, settings: dict[str, float], method: str = "rk4", substeps: int = 4):
        check_binding(binding, file)
        self.binding, self.file, self.calls, self.n = binding, file, 0, binding.n
        self.method, self.substeps = method, substeps
        refuse_events(file)
        self.order, self.nx = state_order(file, binding)
        self.columns = influential(file, binding)
        self.instance = Instance(file, "ME", {**binding.start_values(), **settings})
        self._buffers()
        self._divide_parameters()
        self._chi = np.full(len(binding.parameter), np.nan)

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
        return self._evaluate(s, t)

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
        X, dX, rows = self._batch(len(states))
        X[:, self.order] = states
        set_states, get_derivatives, fmu, nx = self._set_states, self._get_derivatives, self._fmu, self.nx
        status = max(max(set_states(fmu, x, nx), get_derivatives(fmu, dx, nx)) for x, dx in rows)
        self.calls += len(states)
        found = dX[:, self.order[: self.n]]
        if status or not np.isfinite(found).all():
            self.instance.check(status or NOT_FINITE, self._derivatives_call, 0.0)
        return found

    def _batch(self, N: int) -> tuple[np.ndarray, np.ndarray, list]:
        """Buffers (N, nx) of states and derivatives and the pointers to their rows; they only ever grow."""
        if self._rows is None or len(self._rows[0]) < N:
            X, dX = np.zeros((2, N, self.nx))
            pointers = [(x.ctypes.data_as(double_p), dx.ctypes.data_as(double_p)) for x, dx in zip(X, dX, strict=True)]
            self._rows = X, dX, pointers
        X, dX, pointers = self._rows
        return X[:N], dX[:N], pointers[:N]

    def _rk4(self, s: np.ndarray, t: float, step: float) -> np.ndarray:
        evaluate, half, sixth = self._evaluate, 0.5 * step, step / 6.0
        for _ in range(self.substeps):
            total = evaluate(s, t)
            k2 = evaluate(s + half * total, t)
            total += 2.0 * k2
            k3 = evaluate(s + half * k2, t)
            total += 2.0 * k3
            total += evaluate(s + step * k3, t)
            s = s + sixth * total
        return s

    @property
    def directional(self) -> bool:
        """Whether the FMU gives directional derivatives."""
        return self.file.directional("ME")

    def tangents(self) -> tuple[list[str], list[str]]:
        """Unknowns and knowns of the directional derivatives: derivatives by states and inputs, in the seam's order."""
        states = [v.name for v in states_of(self.file)]
        derivatives = [d.variable.name for d in self.file.description.derivatives]
        return [derivatives[i] for i in self.order], [states[i] for i in self.order] + self.inputs.names

    def sensitivity(self, s: np.ndarray, u: np.ndarray, chi: np.ndarray, t: float, dt: float) -> Sensitivity:
        """The transition and its derivatives by s, u and the parameters that are inputs of the FMU, exactly.

        The same steps as `transition`, differentiated: each stage takes the FMU's directional derivatives along.
        """
        if self._tangents is None:
            self._tangents = Tangents(self.instance, *self.tangents())
        self._prepare(s, u, chi, t)
        S = np.eye(self.ns, len(self._tangents.knowns))
        if self.method == "euler":
            k, K = self._stage(s, S, t)
            s, S = s + dt * k, S + dt * K
        else:
            s, S = self._rk4_with_tangents(s, S, t, dt / self.substeps)
        return Sensitivity(s, S[:, : self.ns], S[:, self.ns : self.ns + self.n], S[:, self.ns + self.n :], self.fed)

    def _rk4_with_tangents(self, s: np.ndarray, S: np.ndarray, t: float, step: float) -> tuple[np.ndarray, np.ndarray]:
        half, sixth = 0.5 * step, step / 6.0
        for _ in range(self.substeps):
            k1, K1 = self._stage(s, S, t)
            k2, K2 = self._stage(s + half * k1, S + half * K1, t)
            k3, K3 = self._stage(s + half * k2, S + half * K2, t)
            k4, K4 = self._stage(s + step * k3, S + step * K3, t)
            s = s + sixth * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
            S = S + sixth * (K1 + 2.0 * K2 + 2.0 * K3 + K4)
        return s, S

    def _stage(self, s: np.ndarray, S: np.ndarray, t: float) -> tuple[np.ndarray, np.ndarray]:
        """ds/dt at s, and its derivative along S (ns, m), that of s by all knowns."""
        k = self._evaluate(s, t)
        J = self._tangents(t)
        self.calls += len(self._tangents.knowns)
        K = product(J[:, : self.ns], S)
        K[:, self.ns :] += J[:, self.ns :]
        return k, K

    def _evaluate(self, s: np.ndarray, t: float) -> np.ndarray:
        """Derivatives in the seam's order."""
        self._set(s, t)
        status = self._get_derivatives(self._fmu, self._dx_pointer, self.nx)
        self.calls += 1
        derivative = self._dx[self.order]
        if status or not np.isfinite(derivative.sum()):
            self.instance.check(status or NOT_FINITE, self._derivatives_call, t)
        return derivative

    def _set(self, s: np.ndarray, t: float) -> None:
        """Set the continuous states to s (ns,)."""
        self._x[self.order] = s
        status = self._set_states(self._fmu, self._x_pointer, self.nx)
        if status:
            self.instance.check(status, "SetContinuousStates", t)

    def _prepare(self, s: np.ndarray, u: np.ndarray, chi: np.ndarray, t: float) -> None:
        """Set time, parameters (in Event Mode, only when they changed) and inputs; a new time completes a step."""
        if t != self.t:
            self._complete_step(s, t)
        if not np.array_equal(chi, self._chi):
            self._tune(chi, t)
        status = self.inputs.set(np.concatenate([u, chi[self.fed]]) if self.fed.size else u)
        if status:
            self.instance.check(status, "setting the inputs", t)

    def _complete_step(self, s: np.ndarray, t: float) -> None:
        """Move the time to t, the state s (ns,) being what it is there (FMI 2.0.5, §3.2.1)."""
        self.t, calls, check = t, self.instance.calls, self.instance.check
        check(self._set_time(self._fmu, t), "SetTime", t)
        self._set(s, t)
        if not self.file.description.modelExchange.needsCompletedIntegratorStep:
            return
        status, enter_event_mode, terminate = calls.completed_step()
        check(status or TERMINATE * terminate, "CompletedIntegratorStep", t)
        if enter_event_mode:
            check(calls.enter_event_mode(), "EnterEventMode", t)
            self._leave_event_mode(t)

    def _tune(self, chi: np.ndarray, t: float) -> None:
        """Set the parameters that are not fed as inputs, in Event Mode (2.0.5, §3.2.1; 3.0.2, §3.2.1)."""
        calls, check = self.instance.calls, self.instance.check
        if self.tuned.size and not np.array_equal(chi[self.tuned], self._chi[self.tuned]):
            self._chi[:] = np.nan  # until all is done, nobody knows
            check(calls.enter_event_mode(), "EnterEventMode", t)
            check(self.parameters.set(chi[self.tuned]), "setting the parameters", t)
            self._leave_event_mode(t)
        self._chi[:] = chi

    def _leave_event_mode(self, t: float) -> None:
        self.instance.settle(t)
        self.instance.check(self.instance.calls.enter_continuous_time_mode(), "EnterContinuousTimeMode", t)

    def _divide_parameters(self) -> None:
        """Parameters that the FMU has as inputs are fed beside the plant's input; the others are tuned."""
        names = [p.variable or p.name for p in self.binding.parameter]
        self.tuned, self.fed = tuned_and_fed(self.instance, names)
        self.parameters = References(self.instance, [names[i] for i in self.tuned])
        inputs = [j.input for j in self.binding.joint]
        self.inputs = References(self.instance, [*inputs, *(names[i] for i in self.fed)])

    def _buffers(self) -> None:
        """The arrays and raw calls of the hot loop, resolved once."""
        self._x, self._dx = np.zeros(self.nx), np.zeros(self.nx)
        self._x_pointer, self._dx_pointer = (a.ctypes.data_as(double_p) for a in (self._x, self._dx))
        calls = self.instance.calls
        self._fmu, self._set_time = calls.instance, calls.set_time
        self._set_states, self._get_derivatives = calls.set_states, calls.get_derivatives
        self._derivatives_call = calls.derivatives_call.removeprefix(calls.prefix)
        self._tangents, self._rows, self.t = None, None, 0.0
