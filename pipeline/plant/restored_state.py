"""A plant's transitions by Co-Simulation, each from a restored FMU state."""

from __future__ import annotations

from ctypes import c_int

import numpy as np

from pipeline.errors import ConfigError, FmuError
from pipeline.plant.binding import Binding, check_binding
from pipeline.plant.fmu import Fmu, Instance
from pipeline.plant.references import References
from pipeline.plant.states import refuse_events, state_order


class CoSimulationPlant:
    """A plant by Co-Simulation: each transition restores the FMU state taken before initialisation.

    The standard's legal route for an imposed state (FMI 2.0.5, §2.1.8, §4.2.4): restore, start time t, set states
    and parameters, initialise, one step. There are no derivatives to read. `calls` counts steps.
    """

    interface = "CS"

    def __init__(self, file: Fmu, binding: Binding, settings: dict[str, float], method: str = "rk4", substeps: int = 4):
        check_binding(binding, file)
        refuse_events(file)
        state_order(file, binding)
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
        self._start = References(self.instance, starts)
        self._parameters = References(self.instance, [p.variable or p.name for p in parameters])
        self._inputs = References(self.instance, [j.input for j in joints])
        self._outputs = References(self.instance, [*(j.velocity for j in joints), *(j.position for j in joints)])
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
