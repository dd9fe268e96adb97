"""A plant whose transition and its derivatives are computed by kernels, through the functions of its opened FMU."""

from __future__ import annotations

import numpy as np

from pipeline.errors import ConfigError
from pipeline.interrupts import raise_kept
from pipeline.plant.linearise_kernel import DIFFERENCES, DIRECTIONAL_DERIVATIVES, linearise_once
from pipeline.plant.memory import Memory, connect, refuse
from pipeline.plant.model_exchange import ModelExchangePlant
from pipeline.plant.regressor_kernel import PLANT_FAILED, POINTS, SINGULAR, accelerate_once, torques
from pipeline.plant.restored_state import CoSimulationPlant
from pipeline.plant.steps import EPSILON, floor
from pipeline.plant.transition_kernel import (
    MODEL_EXCHANGE,
    RESET,
    RESTORED,
    plant_fields,
    transition_once,
)

MODES = {"forward": (DIFFERENCES, 0), "central": (DIFFERENCES, 1), "directional": (DIRECTIONAL_DERIVATIVES, 0)}


class CompiledPlant:
    """The face of the plants of Python, on kernels. The plant it is made from, opened, must not be used beside it."""

    compiled = True

    def __init__(self, plant: ModelExchangePlant | CoSimulationPlant):
        self._plant, self.binding, self.file, self.instance = plant, plant.binding, plant.file, plant.instance
        self.interface, self.n, self.ns, self.directional = plant.interface, plant.n, plant.ns, plant.directional
        self.p = len(self.binding.parameter)
        self.memory = Memory(plant_fields(self.n, self.ns, self.p, plant.nx, len(plant.tuned), len(plant.fed)))
        connect(self.memory, self.instance)
        self._variables()
        if self.interface == "ME":
            self._model_exchange()
        else:
            self._co_simulation()

    @property
    def calls(self) -> int:
        """Evaluations of the FMU so far: derivatives and directional ones, or steps."""
        return self._plant.calls + int(self.memory["evaluations"])

    @property
    def columns(self) -> np.ndarray:
        """The places in [s, chi, u] that are differenced; the other columns are the identity's."""
        return np.sort(self.memory["columns"][: self.memory["n_columns"]])

    @columns.setter
    def columns(self, places: np.ndarray) -> None:
        last = (self.ns <= places) & (places < self.ns + self.p)  # parameters cost most: none is set for the others
        self.memory.set(n_columns=len(places))
        self.memory["columns"][: len(places)] = [*places[~last], *places[last]]

    def transition(self, s: np.ndarray, u: np.ndarray, chi: np.ndarray, t: float, dt: float) -> np.ndarray:
        """The state (ns,) after dt (s) with u (n,) held. Raises FmuError where the FMU refuses or gives no number."""
        self.memory["point"][:] = np.concatenate([s, chi, u])
        self.check(transition_once(self.memory.record, float(t), float(dt)), t)
        return self.memory["f"].copy()

    def linearise(
        self, s: np.ndarray, u: np.ndarray, chi: np.ndarray, t: float, dt: float, mode: str
    ) -> tuple[np.ndarray, np.ndarray]:
        """The transition f (ns,) and its derivatives J (ns, ns + p + n) by s, chi and u."""
        self.memory["point"][:] = np.concatenate([s, chi, u])
        how, central, step = self.begin(mode)
        self.check(linearise_once(self.memory.record, float(t), float(dt), how, step, central), t)
        return self.memory["f"].copy(), self.memory["J"].T.copy()

    def accelerations(self, q: np.ndarray, qd: np.ndarray, u: np.ndarray, chi: np.ndarray) -> np.ndarray:
        """qdd (N, n) at q, qd (N, n), all with the same input u (n,) and parameters chi (p,), at time 0."""
        q, qd, u, chi = map(_doubles, (q, qd, u, chi))
        X, qdd = np.empty((len(q), len(self.memory["x"]))), np.empty(q.shape)
        at = [array.ctypes.data for array in (q, qd, X, u, chi, qdd)]
        self.check(accelerate_once(self.memory.record, *at[:2], len(q), *at[2:]), 0.0)
        return qdd

    def torques(
        self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, chi: np.ndarray, own: np.ndarray, step: np.ndarray
    ) -> np.ndarray:
        """tau (sets, N, n) that gives qdd (N, n) at q, qd (N, n) for sets of parameters chi (sets, p), at time 0.

        own (sets,): whether a set has a mass matrix of its own, else it has that of the first; step (n,): the inputs
        by which it is probed. Raises LinAlgError where one is singular.
        """
        (N, n), points = q.shape, Memory(POINTS)
        points.set(N=N, sets=len(chi))
        points.put(q=_doubles(q), qd=_doubles(qd), qdd=_doubles(qdd), chi=chi, own=own.astype(np.int64))
        points.put(step=step, force=self.binding.gain * step, tau=np.empty((len(chi), N, n)))
        points.room(X=(N, len(self.memory["x"])), free=(N, n), J=(2, N, n, n), A=(n, n))
        points.room(u=n, still=n, pushed=n)
        how = torques(self.memory.record, points.record)
        self.check(how == PLANT_FAILED, 0.0)
        if how == SINGULAR:
            raise np.linalg.LinAlgError("singular matrix")
        return points["tau"]

    def begin(self, mode: str) -> tuple[int, int, float]:
        """Clear J of what another mode left, and give the kernels' words for this one: how, central, epsilon.

        Raises ConfigError for directional derivatives where there are none.
        """
        if mode == "directional" and not self.directional:
            raise ConfigError(f'{self.file.path.name}: no directional derivatives; use ekf.jacobian = "forward"')
        self.memory.set(J=np.eye(self.ns + self.p + self.n, self.ns))
        how, central = MODES[mode]
        return how, central, EPSILON["central" if central else "forward"]

    def check(self, failed: bool, t: float) -> None:
        """Raise FmuError for a kernel that failed at t (s), naming the call and its status."""
        raise_kept()
        if failed:
            self.memory.set(parameters=np.nan, inputs=np.nan)  # nobody knows what the FMU has
            refuse(self.memory, self.instance, t)

    def _variables(self) -> None:
        """Inputs, and parameters: those that are tuned and those that are fed as inputs."""
        plant, memory = self._plant, self.memory
        memory.set(n=self.n, p=self.p, tuned=self.ns + plant.tuned, fed=self.ns + plant.fed)
        memory.set(parameters=np.nan, inputs=np.nan)
        memory.set(floor=floor(self.binding, self.ns), gain=self.binding.gain, seed=1.0)
        memory.put(tuned_vr=plant.parameters.vr, input_vr=plant.inputs.vr)
        self.columns = plant.columns

    def _model_exchange(self) -> None:
        plant, memory = self._plant, self.memory
        substeps = 0 if plant.method == "euler" else plant.substeps
        completes = plant.file.description.modelExchange.needsCompletedIntegratorStep
        memory.set(kind=MODEL_EXCHANGE, substeps=substeps, t=plant.t, completes=bool(completes), order=plant.order)
        if self.directional:
            places = [*range(self.ns), *(self.ns + self.p + np.arange(self.n)), *(self.ns + plant.fed)]
            unknowns, knowns = ([self.file.reference(v) for v in names] for names in plant.tangents())
            memory.set(known_column=places)
            memory.put(unknown_vr=np.array(unknowns, np.uint32), known_vr=np.array(knowns, np.uint32))

    def _co_simulation(self) -> None:
        plant, memory = self._plant, self.memory
        memory.put(state_vr=plant.start.vr, output_vr=plant.outputs.vr)
        if plant.restores == "state":
            memory.set(kind=RESTORED, snapshot=plant.snapshot.value)
        else:
            memory.set(kind=RESET, n_settings=plant.settings.n)
            memory.put(setting_vr=plant.settings.vr, settings=plant.values)


def _doubles(values) -> np.ndarray:
    return np.ascontiguousarray(values, dtype=float)
