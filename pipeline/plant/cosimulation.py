"""A Co-Simulation slave: start values in, inputs in, a step, outputs out. Every status but OK is an FmuError."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from os import PathLike

import numpy as np

from pipeline.errors import FmuError
from pipeline.plant.fmu import NOT_FINITE, REAL, Fmu, Instance, open_fmu
from pipeline.plant.references import References


class Port:
    """Some Real variables of a slave, resolved once: `write` sets them, `read` gets them, through one reused buffer."""

    def __init__(self, slave: Slave, names: Sequence[str]):
        for name in names:
            _check_real(slave.file, name)
        self.slave, self.names = slave, tuple(names)
        self._variables = References(slave.instance, names)
        self.references, self.values = self._variables.vr, self._variables.buffer

    def write(self, values: np.ndarray) -> None:
        """Set the variables to values (n,); NaN is refused before the FMU sees it."""
        self.values[:] = values
        finite = np.isfinite(self.values).all()
        self.check(self._variables.set(self.values) if finite else NOT_FINITE, writing=True)

    def read(self) -> np.ndarray:
        """The variables' values (n,), a copy; FmuError where one is not finite."""
        status = self._variables.get()
        self.check(status or NOT_FINITE * (not np.isfinite(self.values).all()), writing=False)
        return self.values.copy()

    def check(self, status: int, writing: bool) -> None:
        """Raise FmuError unless the status that writing, or reading, ended with is OK."""
        if status == NOT_FINITE:
            k = int(np.argmin(np.isfinite(self.values)))
            raise FmuError(
                f"{self.slave.file.path.name}: `{self.names[k]}` {'is given' if writing else 'became'} "
                f"{self.values[k]} at t = {self.slave.t:g} s; check start values, parameters and the step"
            )
        if status:
            calls = self.slave.instance.calls
            self.slave.instance.check(status, (calls.set if writing else calls.get).__name__[4:], self.slave.t)


class Slave(AbstractContextManager):
    """An initialised Co-Simulation instance of an FMU at its communication point `t` (s); freed at the end of `with`.

    file: an opened FMU, or a path, which is then opened for as long as the slave lives. start: values by variable
    name, set before initialisation (FMI 2.0.5, section 4.2.4). Raises FmuError.
    """

    def __init__(self, file: Fmu | str | PathLike, start: Mapping[str, float] | None = None, t0: float = 0.0):
        self._owned = None if isinstance(file, Fmu) else open_fmu(file)
        self.file: Fmu = self._owned or file
        self.instance, self.t = None, t0
        try:
            for name in start or {}:
                _check_real(self.file, name)
            self.instance = Instance(self.file, "CS")
            self.instance.initialize(dict(start or {}), t0)
        except BaseException:
            self.close()
            raise

    def __exit__(self, *exc) -> None:
        self.close()

    def port(self, names: Sequence[str]) -> Port:
        """The variables called `names`, to be read or written together."""
        return Port(self, names)

    def step(self, t: float, dt: float) -> None:
        """Advance from the communication point t to t + dt (s); t = t0 + k·dt keeps errors from piling up."""
        self.t = t
        self.check(self.instance.calls.do_step(t, dt))
        self.t = t + dt

    def check(self, status: int) -> None:
        """Raise FmuError unless the status of a step from here is OK."""
        self.instance.check(status, "DoStep", self.t)

    def close(self) -> None:
        """Free the instance, and the FMU's folder where the slave opened it; harmless when repeated."""
        instance, self.instance = self.instance, None
        if instance is not None:
            instance.__exit__(None, None, None)
        owned, self._owned = self._owned, None
        if owned is not None:
            owned.__exit__(None, None, None)


def _check_real(file: Fmu, name: str) -> None:
    variable = file.variable(name)
    if variable.type not in REAL:
        raise FmuError(f"{file.path.name}: `{name}` is of type {variable.type}; only Real variables can be coupled")
