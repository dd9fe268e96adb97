"""FMI 3.0 by raw calls, with the face of `fmi2.py`."""

from __future__ import annotations

from ctypes import byref, c_bool, c_double, c_void_p, cast

from fmpy.fmi3 import FMU3Model, FMU3Slave
from fmpy.model_description import ModelDescription

from pipeline.plant.log import keep

KINDS = {"ME": FMU3Model, "CS": FMU3Slave}
DISCARD = 2


class Fmi3:
    """An instance of an FMI 3.0 FMU, "ME" or "CS" without Event Mode; the calls are explained in `Fmi2`."""

    prefix, derivatives_call = "fmi3", "fmi3GetContinuousStateDerivatives"
    functions = {
        "get": "GetFloat64", "set": "SetFloat64", "set_states": "SetContinuousStates",
        "get_derivatives": "GetContinuousStateDerivatives", "set_time": "SetTime",
        "enter_event_mode": "EnterEventMode", "update_discrete_states": "UpdateDiscreteStates",
        "enter_continuous_time_mode": "EnterContinuousTimeMode", "completed_step": "CompletedIntegratorStep",
        "enter_initialization": "EnterInitializationMode", "exit_initialization": "ExitInitializationMode",
        "do_step": "DoStep", "set_state": "SetFMUState", "reset": "Reset", "directional": "GetDirectionalDerivative",
    }  # fmt: skip

    def __init__(self, description: ModelDescription, interface: str, folder: str, name: str, log: list[str]):
        offered = description.modelExchange if interface == "ME" else description.coSimulation
        self._fmu = KINDS[interface](
            guid=description.guid, modelIdentifier=offered.modelIdentifier, unzipDirectory=folder, instanceName=name
        )
        try:
            self._fmu.instantiate(logMessage=lambda environment, status, category, message: keep(log, message))
        except Exception:  # bare Exception of fmpy: no instance, and no use for its library
            self._fmu.freeLibrary()
            raise
        self.instance, self._dll = self._fmu.component, self._fmu.dll
        self.get, self.set = self._dll.fmi3GetFloat64, self._dll.fmi3SetFloat64
        self._flags, self._reached = [c_bool() for _ in range(5)], c_double()
        if interface == "ME":
            self.set_states = self._dll.fmi3SetContinuousStates
            self.get_derivatives = self._dll.fmi3GetContinuousStateDerivatives
            self.set_time = self._dll.fmi3SetTime

    def address(self, function: str) -> int:
        """Where the function called so in `functions` stands in memory; 0 where there is none."""
        found = getattr(self._dll, self.prefix + self.functions[function], None) if function in self.functions else None
        return 0 if found is None else cast(found, c_void_p).value

    def values(self, references, n: int, pointer) -> tuple:
        """The arguments of `get` and `set`."""
        return self.instance, references, n, pointer, n

    def free(self) -> None:
        """Free the instance and its library."""
        self._fmu.freeInstance()

    def setup(self, t0: float) -> int:
        """Nothing: the start time comes with the initialisation (section 2.3.2)."""
        return 0

    def enter_initialization(self, t0: float) -> int:
        """Instantiated → Initialization Mode, the run starting at t0 (s)."""
        return self._dll.fmi3EnterInitializationMode(self.instance, False, 0.0, t0, False, 0.0)

    def reset(self) -> int:
        """Back to Instantiated."""
        return self._dll.fmi3Reset(self.instance)

    def exit_initialization(self) -> int:
        """Initialization Mode → Event Mode (ME), or Step Mode (CS)."""
        return self._dll.fmi3ExitInitializationMode(self.instance)

    def enter_event_mode(self) -> int:
        """Continuous-Time Mode → Event Mode."""
        return self._dll.fmi3EnterEventMode(self.instance)

    def update_discrete_states(self) -> tuple[int, bool, bool]:
        """An event iteration: status, whether another is needed, whether the FMU asks to terminate."""
        flags = self._flags
        status = self._dll.fmi3UpdateDiscreteStates(self.instance, *map(byref, flags), byref(self._reached))
        return status, flags[0].value, flags[1].value

    def enter_continuous_time_mode(self) -> int:
        """Event Mode → Continuous-Time Mode."""
        return self._dll.fmi3EnterContinuousTimeMode(self.instance)

    def completed_step(self) -> tuple[int, bool, bool]:
        """After a step: status, whether Event Mode is wanted, whether the FMU asks to terminate."""
        enter, end, *_ = self._flags
        status = self._dll.fmi3CompletedIntegratorStep(self.instance, False, byref(enter), byref(end))
        return status, enter.value, end.value

    def do_step(self, t: float, dt: float) -> int:
        """A Co-Simulation step from t to t + dt (s); one that ends early counts as Discard, as in FMI 2.0."""
        event, end, early, *_ = self._flags
        status = self._dll.fmi3DoStep(
            self.instance, t, dt, False, byref(event), byref(end), byref(early), byref(self._reached)
        )
        return max(status, DISCARD) if end.value or early.value else status

    def get_state(self) -> tuple[int, c_void_p]:
        """Status and a new FMU state."""
        state = c_void_p()
        return self._dll.fmi3GetFMUState(self.instance, byref(state)), state

    def set_state(self, state: c_void_p) -> int:
        """Restore an FMU state."""
        return self._dll.fmi3SetFMUState(self.instance, state)

    def free_state(self, state: c_void_p) -> int:
        """Free an FMU state."""
        return self._dll.fmi3FreeFMUState(self.instance, byref(state))

    def directional(self, unknowns, n: int, knowns, m: int, seed, result) -> int:
        """result (n,) = ∂unknowns/∂knowns · seed (m,) (section 2.2.11)."""
        return self._dll.fmi3GetDirectionalDerivative(self.instance, unknowns, n, knowns, m, seed, m, result, n)
