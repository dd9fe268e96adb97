"""FMI 2.0 by raw calls. `fmi3.py` has the same face, so that nothing else in this room knows of a version."""

from __future__ import annotations

from ctypes import byref, c_int, c_void_p, cast

from fmpy.fmi2 import FMU2Model, FMU2Slave, fmi2EventInfo
from fmpy.model_description import ModelDescription

from pipeline.plant.log import callbacks

KINDS = {"ME": FMU2Model, "CS": FMU2Slave}


class Fmi2:
    """An instance of an FMI 2.0 FMU, "ME" or "CS", loaded and instantiated by fmpy; calls give a status (0: OK).

    Calls with `instance` first are the library's own: get and set (see `values`), set_states, get_derivatives (array,
    count), set_time (t). The others are methods.
    """

    prefix, derivatives_call = "fmi2", "fmi2GetDerivatives"
    functions = {
        "get": "GetReal", "set": "SetReal", "set_states": "SetContinuousStates", "get_derivatives": "GetDerivatives",
        "set_time": "SetTime", "enter_event_mode": "EnterEventMode", "update_discrete_states": "NewDiscreteStates",
        "enter_continuous_time_mode": "EnterContinuousTimeMode", "completed_step": "CompletedIntegratorStep",
        "setup": "SetupExperiment", "enter_initialization": "EnterInitializationMode",
        "exit_initialization": "ExitInitializationMode", "do_step": "DoStep", "set_state": "SetFMUstate",
        "reset": "Reset", "directional": "GetDirectionalDerivative",
    }  # fmt: skip

    def __init__(self, description: ModelDescription, interface: str, folder: str, name: str, log: list[str]):
        offered = description.modelExchange if interface == "ME" else description.coSimulation
        self._fmu = KINDS[interface](
            guid=description.guid, modelIdentifier=offered.modelIdentifier, unzipDirectory=folder, instanceName=name
        )
        try:
            self._fmu.instantiate(callbacks=callbacks)
        except Exception:  # bare Exception of fmpy: no instance, and no use for its library
            self._fmu.freeLibrary()
            raise
        self.instance, self._dll = self._fmu.component, self._fmu.dll
        self.get, self.set = self._dll.fmi2GetReal, self._dll.fmi2SetReal
        if interface == "ME":
            self.set_states, self.get_derivatives = self._dll.fmi2SetContinuousStates, self._dll.fmi2GetDerivatives
            self.set_time = self._dll.fmi2SetTime
            self._event, self._flags = fmi2EventInfo(), (c_int(), c_int())

    def address(self, function: str) -> int:
        """Where the function called so in `functions` stands in memory; 0 where the library has none."""
        found = getattr(self._dll, self.prefix + self.functions[function], None)
        return 0 if found is None else cast(found, c_void_p).value

    def values(self, references, n: int, pointer) -> tuple:
        """The arguments of `get` and `set`."""
        return self.instance, references, n, pointer

    def free(self) -> None:
        """Free the instance and its library."""
        self._fmu.freeInstance()

    def setup(self, t0: float) -> int:
        """Before initialisation: the run starts at t0 (s)."""
        return self._dll.fmi2SetupExperiment(self.instance, 0, 0.0, t0, 0, 0.0)

    def enter_initialization(self, t0: float) -> int:
        """Instantiated → Initialization Mode; t0 is known from `setup`."""
        return self._dll.fmi2EnterInitializationMode(self.instance)

    def reset(self) -> int:
        """Back to Instantiated."""
        return self._dll.fmi2Reset(self.instance)

    def exit_initialization(self) -> int:
        """Initialization Mode → Event Mode (ME), or ready to step (CS)."""
        return self._dll.fmi2ExitInitializationMode(self.instance)

    def enter_event_mode(self) -> int:
        """Continuous-Time Mode → Event Mode."""
        return self._dll.fmi2EnterEventMode(self.instance)

    def update_discrete_states(self) -> tuple[int, bool, bool]:
        """An event iteration: status, whether another is needed, whether the FMU asks to terminate."""
        status = self._dll.fmi2NewDiscreteStates(self.instance, byref(self._event))
        return status, bool(self._event.newDiscreteStatesNeeded), bool(self._event.terminateSimulation)

    def enter_continuous_time_mode(self) -> int:
        """Event Mode → Continuous-Time Mode."""
        return self._dll.fmi2EnterContinuousTimeMode(self.instance)

    def completed_step(self) -> tuple[int, bool, bool]:
        """After a step: status, whether Event Mode is wanted, whether the FMU asks to terminate."""
        enter, end = self._flags
        status = self._dll.fmi2CompletedIntegratorStep(self.instance, 0, byref(enter), byref(end))
        return status, bool(enter.value), bool(end.value)

    def do_step(self, t: float, dt: float) -> int:
        """A Co-Simulation step from t to t + dt (s)."""
        return self._dll.fmi2DoStep(self.instance, t, dt, 0)

    def get_state(self) -> tuple[int, c_void_p]:
        """Status and a new FMU state."""
        state = c_void_p()
        return self._dll.fmi2GetFMUstate(self.instance, byref(state)), state

    def set_state(self, state: c_void_p) -> int:
        """Restore an FMU state."""
        return self._dll.fmi2SetFMUstate(self.instance, state)

    def free_state(self, state: c_void_p) -> int:
        """Free an FMU state."""
        return self._dll.fmi2FreeFMUstate(self.instance, byref(state))

    def directional(self, unknowns, n: int, knowns, m: int, seed, result) -> int:
        """result (n,) = ∂unknowns/∂knowns · seed (m,) (section 2.1.9)."""
        return self._dll.fmi2GetDirectionalDerivative(self.instance, unknowns, n, knowns, m, seed, result)
