"""Real variables of an FMU behind raw calls: value references resolved once, one reused buffer."""

from __future__ import annotations

from collections.abc import Sequence
from ctypes import POINTER, c_double, c_uint

import numpy as np

from pipeline.plant.fmu import Instance

double_p = POINTER(c_double)


def tuned_and_fed(instance: Instance, names: Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
    """The places of those that are parameters of the FMU, to be tuned, and of those that are its inputs, to be fed."""
    is_input = np.array([instance.file.variable(name).causality == "input" for name in names], bool)
    return np.flatnonzero(~is_input), np.flatnonzero(is_input)


class References:
    """Value references and a reused buffer: `set` writes an array into the FMU's variables, `get` reads them."""

    def __init__(self, instance: Instance, names: Sequence[str]):
        file, calls = instance.file, instance.calls
        self.names, self.n = list(names), len(names)
        self.vr = (c_uint * self.n)(*[file.reference(name) for name in names])
        self.buffer = np.zeros(self.n)
        self.pointer = self.buffer.ctypes.data_as(double_p)
        self._arguments = calls.values(self.vr, self.n, self.pointer)
        self._set, self._get = calls.set, calls.get

    def set(self, values: np.ndarray) -> int:
        """Write values (n,); gives the status."""
        self.buffer[:] = values
        return self._set(*self._arguments)

    def get(self) -> int:
        """Read into `buffer`; gives the status."""
        return self._get(*self._arguments)
