"""A plant's transitions by Co-Simulation, each from a restored FMU state."""

from __future__ import annotations

import numpy as np

from pipeline.errors import ConfigError, FmuError
from pipeline.plant.binding import Binding, check_binding
from pipeline.plant.fmu import NOT_FINITE, Fmu, Instance
from pipeline.plant.references import References, tuned_and_fed
from pipeline.plant.states import influential, refuse_events, state_order


class CoSimulationPlant:
    """A plant by Co-Simulation: each transition begins with the FMU as it was before its initialisation.

    The standard's legal route for an imposed state (FMI 2.0.5, §2.1.8, §4.2.4): go back, start time t, set states
    and parameters, initialise, one step. Back by the FMU state that was taken, or (restores = "reset") by a reset,
    after which the start values are set again. There are no derivatives to read. `calls` counts steps.
    """

    interface, compiled = "CS", False

    def __init__(self, file: Fmu, binding: Binding, settings: dict[str, float], restores: str = "state"):
        check_binding(binding, file)
        refuse_events(file)
        _, self.nx = state_order(file, binding)
        self.columns = influential(file, binding)
        if restores == "state" and file.supports("CS") and not file.description.coSimulation.canGetAndSetFMUstate:
            raise FmuError(
                f'{file.path.name}: cannot get and set its FMU state; use ekf.interface = "CS reset", or "ME"'
            )
        for joint in binding.joint:
            if not (joint.position_start and joint.velocity_start):
                raise ConfigError(
                    f"joint {joint.name}: Co-Simulation needs position_start and velocity_start in the binding"
                )
        self.binding, self.file, self.calls, self.n, self.restores = binding, file, 0, binding.n, restores
        self.instance = Instance(file, "CS")
        try:
            self._set_up({**binding.start_values(), **settings})
        except BaseException:
            self.instance.__exit__(None, None, None)
            raise

    def _set_up(self, start: dict[str, float]) -> None:
        """Resolve the variables, set the start values, and keep the FMU state of before initialisation."""
        joints, parameters = self.binding.joint, self.binding.parameter
        starts = [*(j.velocity_start for j in joints), *(j.position_start for j in joints)]
        self.start = References(self.instance, starts)
        names = [p.variable or p.name for p in parameters]
        self.tuned, self.fed = tuned_and_fed(self.instance, names)
        self.parameters = References(self.instance, [names[i] for i in self.tuned])
        self.inputs = References(self.instance, [*(j.input for j in joints), *(names[i] for i in self.fed)])
        self.outputs = References(self.instance, [*(j.velocity for j in joints), *(j.position for j in joints)])
        settings = {name: value for name, value in start.items() if name not in self.inputs.names}
        self.settings = References(self.instance, list(settings))
        self.values = np.array(list(settings.values()))
        self.instance.set(settings)
        self.snapshot = None
        if self.restores == "state":
            status, self.snapshot = self.instance.calls.get_state()
            self.instance.check(status, "GetFMUstate", 0.0)

    def __enter__(self) -> CoSimulationPlant:
        return self

    def __exit__(self, *exc) -> None:
        if self.snapshot is not None:
            self.instance.calls.free_state(self.snapshot)
        self.instance.__exit__(*exc)

    @property
    def directional(self) -> bool:
        """Never: by Co-Simulation, they would be the derivatives at a communication point, not those of the step."""
        return False

    @property
    def ns(self) -> int:
        """Number of plant states, 2n."""
        return 2 * self.n

    def transition(self, s: np.ndarray, u: np.ndarray, chi: np.ndarray, t: float, dt: float) -> np.ndarray:
        """The state (ns,) after dt (s) with u (n,) held. Raises FmuError where the FMU refuses or gives no number."""
        calls, check = self.instance.calls, self.instance.check
        self.calls += 1
        self._go_back(t)
        check(self.start.set(s), "setting the states", t)
        check(self.parameters.set(chi[self.tuned]), "setting the parameters", t)
        check(calls.enter_initialization(t), "EnterInitializationMode", t)
        check(self.inputs.set(np.concatenate([u, chi[self.fed]])), "setting the inputs", t)
        check(calls.exit_initialization(), "ExitInitializationMode", t)
        check(calls.do_step(t, dt), "DoStep", t)
        check(self.outputs.get(), "reading the outputs", t)
        result = self.outputs.buffer.copy()
        check(NOT_FINITE * (not np.isfinite(result.sum())), "DoStep", t)
        return result

    def sensitivity(self, s: np.ndarray, u: np.ndarray, chi: np.ndarray, t: float, dt: float):
        """Raises ConfigError: there are no derivatives of a step."""
        raise ConfigError(f'{self.file.path.name}: no directional derivatives; use ekf.jacobian = "forward"')

    def _go_back(self, t: float) -> None:
        """The instance as before its initialisation, to start at t (s)."""
        calls, check = self.instance.calls, self.instance.check
        if self.snapshot is not None:
            check(calls.set_state(self.snapshot), "SetFMUstate", t)
            check(calls.setup(t), "SetupExperiment", t)
            return
        check(calls.reset(), "Reset", t)
        check(calls.setup(t), "SetupExperiment", t)
        check(self.settings.set(self.values), "setting the start values", t)
