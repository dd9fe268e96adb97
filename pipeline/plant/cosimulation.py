"""A Co-Simulation slave: start values in, inputs in, a step, outputs out. Every status but OK is an FmuError."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from os import PathLike

import numpy as np

from pipeline.errors import FmuError
from pipeline.plant.fmu import REAL, Fmu, Instance, open_fmu
from pipeline.plant.references import References


class Port:
    """Some Real variables of a slave, resolved once: `write` sets them, `read` gets them, through one reused buffer."""

    def __init__(self, slave: Slave, instance: Instance, names: Sequence[str]):
        for name in names:
            _check_real(slave.file, name)
        self._slave, self._instance, self.names = slave, instance, tuple(names)
        self._variables = References(instance, names)

    def write(self, values: np.ndarray) -> None:
        """Set the variables to values (n,); NaN is refused before the FMU sees it."""
        self._check_finite("is given", np.asarray(values, float))
        status = self._variables.set(values)
        if status:
            self._instance.check(status, self._instance.calls.set.__name__[4:], self._slave.t)

    def read(self) -> np.ndarray:
        """The variables' values (n,), a copy; FmuError where one is not finite."""
        status = self._variables.get()
        if status:
            self._instance.check(status, self._instance.calls.get.__name__[4:], self._slave.t)
        self._check_finite("became", self._variables.buffer)
        return self._variables.buffer.copy()

    def _check_finite(self, verb: str, values: np.ndarray) -> None:
        finite = np.isfinite(values)
        if not finite.all():
            k = int(np.argmin(finite))
            raise FmuError(
                f"{self._slave.file.path.name}: `{self.names[k]}` {verb} {values[k]} at t = {self._slave.t:g} s; "
                "check start values, parameters and the step"
            )


class Slave(AbstractContextManager):
    """An initialised Co-Simulation instance of an FMU at its communication point `t` (s); freed at the end of `with`.

    file: an opened FMU, or a path, which is then opened for as long as the slave lives. start: values by variable
    name, set before initialisation (FMI 2.0.5, section 4.2.4). Raises FmuError.
    """

    def __init__(self, file: Fmu | str | PathLike, start: Mapping[str, float] | None = None, t0: float = 0.0):
        self._owned = None if isinstance(file, Fmu) else open_fmu(file)
        self.file: Fmu = self._owned or file
        self._instance, self.t = None, t0
        try:
            for name in start or {}:
                _check_real(self.file, name)
            self._instance = Instance(self.file, "CS")
            self._instance.initialize(dict(start or {}), t0)
        except BaseException:
            self.close()
            raise

    def __exit__(self, *exc) -> None:
        self.close()

    def port(self, names: Sequence[str]) -> Port:
        """The variables called `names`, to be read or written together."""
        return Port(self, self._instance, names)

    def step(self, t: float, dt: float) -> None:
        """Advance from the communication point t to t + dt (s); t = t0 + k·dt keeps errors from piling up."""
        self.t = t
        self._instance.check(self._instance.calls.do_step(t, dt), "DoStep", t)
        self.t = t + dt

    def close(self) -> None:
        """Free the instance, and the FMU's folder where the slave opened it; harmless when repeated."""
        instance, self._instance = self._instance, None
        if instance is not None:
            instance.__exit__(None, None, None)
        owned, self._owned = self._owned, None
        if owned is not None:
            owned.__exit__(None, None, None)


def _check_real(file: Fmu, name: str) -> None:
    variable = file.variable(name)
    if variable.type not in REAL:
        raise FmuError(f"{file.path.name}: `{name}` is of type {variable.type}; only Real variables can be coupled")
