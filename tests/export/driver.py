"""FMU instances for the tests, straight on fmpy: names instead of value references, a context manager, no more."""

from contextlib import contextmanager
from ctypes import POINTER, c_double, cast
from shutil import rmtree

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.fmi3 import FMU3Model, FMU3Slave


class Archive:
    """An unpacked FMU: `path`, its `description`, `states` and `derivatives` by name in the order of Model Exchange."""

    def __init__(self, path, folder=None):
        self.path = path
        self.description = fmpy.read_model_description(str(path), validate=False)
        self.folder = fmpy.extract(str(path), None if folder is None else str(folder))
        self.references = {v.name: v.valueReference for v in self.description.modelVariables}
        self.derivatives = [u.variable.name for u in self.description.derivatives]
        self.states = [u.variable.derivative.name for u in self.description.derivatives]

    def close(self):
        rmtree(self.folder, ignore_errors=True)

    @contextmanager
    def model_exchange(self, start=0.0, **values):
        """An initialised Model Exchange instance in Continuous-Time Mode, events of the start handled."""
        with self._instance(self.description.modelExchange, start, values) as instance:
            instance.next_event = instance.settle()
            instance.fmu.enterContinuousTimeMode()
            yield instance

    @contextmanager
    def event_mode(self, start=0.0, **values):
        """An initialised Model Exchange instance in its first Event Mode: the events of the start are still to come."""
        with self._instance(self.description.modelExchange, start, values) as instance:
            yield instance

    @contextmanager
    def co_simulation(self, start=0.0, **values):
        """An initialised Co-Simulation instance."""
        with self._instance(self.description.coSimulation, start, values) as instance:
            yield instance

    @contextmanager
    def initialization_mode(self, start=0.0, interface="modelExchange", **values):
        """An instance in Initialization Mode."""
        with self._instantiated(getattr(self.description, interface), start, values) as instance:
            yield instance

    @contextmanager
    def _instance(self, interface, start, values):
        with self._instantiated(interface, start, values) as instance:
            instance.fmu.exitInitializationMode()
            yield instance
            instance.fmu.terminate()

    @contextmanager
    def _instantiated(self, interface, start, values):
        version, co_simulation = self.description.fmiVersion[0], interface is self.description.coSimulation
        kinds = {"2": (FMU2Model, FMU2Slave, Instance), "3": (FMU3Model, FMU3Slave, Instance3)}[version]
        fmu = kinds[co_simulation](
            guid=self.description.guid,
            unzipDirectory=self.folder,
            modelIdentifier=interface.modelIdentifier,
            instanceName="test",
        )
        fmu.instantiate()
        try:
            instance = kinds[2](fmu, self)
            instance.initialize(start, values)
            yield instance
        finally:
            fmu.freeInstance()


class Instance:
    """One instance: variables by name, and the calls of FMI 2.0 that the tests need."""

    def __init__(self, fmu, archive):
        self.fmu, self.archive = fmu, archive
        self.x, self.dx = np.empty(len(archive.states)), np.empty(len(archive.states))
        self._x, self._dx = (cast(a.ctypes.data, POINTER(c_double)) for a in (self.x, self.dx))

    def initialize(self, start, values):
        """Set up, set `values`, enter Initialization Mode."""
        self.fmu.setupExperiment(startTime=start)
        self.set(**values)
        self.fmu.enterInitializationMode()

    def set(self, **values):
        """Set variables by keyword; a dotted name has `__` for the dot."""
        if values:
            names = [name.replace("__", ".") for name in values]
            self.fmu.setReal([self.archive.references[n] for n in names], [float(v) for v in values.values()])

    def get(self, *names):
        """Values of the named variables (len(names),)."""
        return np.array(self.fmu.getReal([self.archive.references[n] for n in names]))

    def step(self, t, h):
        """One communication step."""
        self.fmu.doStep(t, h)

    def directional(self, unknowns, knowns, seed):
        """∂unknowns/∂knowns · seed (len(unknowns),)."""
        unknowns, knowns = ([self.archive.references[n] for n in names] for names in (unknowns, knowns))
        return np.array(self._directional(unknowns, knowns, [float(s) for s in seed]))

    def _directional(self, unknowns, knowns, seed):
        return self.fmu.getDirectionalDerivative(unknowns, knowns, seed)

    def settle(self):
        """Iterate discrete states until none is left; the time of the next event, or None."""
        for _ in range(10):
            needed, _, _, _, defined, when = self.fmu.newDiscreteStates()
            if not needed:
                return when if defined else None
        raise AssertionError("the event iteration does not end")

    def event(self, **values):
        """Enter Event Mode, set `values`, iterate, go back to Continuous-Time Mode; the time of the next event."""
        self.fmu.enterEventMode()
        self.set(**values)
        self.next_event = self.settle()
        self.fmu.enterContinuousTimeMode()
        return self.next_event

    def rhs(self, t, x):
        """Derivatives (n,) of the states x (n,) at time t."""
        self.x[:] = x
        self.fmu.setTime(t)
        self.fmu.setContinuousStates(self._x, self.x.size)
        self.fmu.getDerivatives(self._dx, self.dx.size)
        return self.dx.copy()

    def continuous_states(self):
        """States (n,) in the order of the description."""
        self.fmu.getContinuousStates(self._x, self.x.size)
        return self.x.copy()

    def save(self):
        """The FMU state as bytes, through get, serialise and free."""
        state = self.fmu.getFMUstate()
        frozen = self.fmu.serializeFMUstate(state)
        self.fmu.freeFMUstate(state)
        return frozen

    def load(self, frozen):
        """Set the FMU state from bytes."""
        state = self.fmu.deSerializeFMUstate(frozen)
        self.fmu.setFMUstate(state)
        self.fmu.freeFMUstate(state)


class Instance3(Instance):
    """The same with the calls of FMI 3.0."""

    def initialize(self, start, values):
        self.set(**values)
        self.fmu.enterInitializationMode(startTime=start)

    def set(self, **values):
        if values:
            names = [name.replace("__", ".") for name in values]
            self.fmu.setFloat64([self.archive.references[n] for n in names], [float(v) for v in values.values()])

    def get(self, *names):
        return np.array(self.fmu.getFloat64([self.archive.references[n] for n in names]))

    def _directional(self, unknowns, knowns, seed):
        return self.fmu.getDirectionalDerivative(unknowns, knowns, seed, len(unknowns))

    def adjoint(self, unknowns, knowns, seed):
        """seed · ∂unknowns/∂knowns (len(knowns),)."""
        unknowns, knowns = ([self.archive.references[n] for n in names] for names in (unknowns, knowns))
        return np.array(self.fmu.getAdjointDerivative(unknowns, knowns, [float(s) for s in seed], len(knowns)))

    def settle(self):
        for _ in range(10):
            needed, _, _, _, defined, when = self.fmu.updateDiscreteStates()
            if not needed:
                return when if defined else None
        raise AssertionError("the event iteration does not end")

    def rhs(self, t, x):
        self.x[:] = x
        self.fmu.setTime(t)
        self.fmu.setContinuousStates(self._x, self.x.size)
        self.fmu.getContinuousStateDerivatives(self._dx, self.dx.size)
        return self.dx.copy()

    def save(self):
        state = self.fmu.getFMUState()
        frozen = self.fmu.serializeFMUState(state)
        self.fmu.freeFMUState(state)
        return frozen

    def load(self, frozen):
        state = self.fmu.deserializeFMUState(frozen)
        self.fmu.setFMUState(state)
        self.fmu.freeFMUState(state)
