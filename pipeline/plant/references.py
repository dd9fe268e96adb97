"""Real variables of an FMU behind raw calls: value references resolved once, one reused buffer."""

from __future__ import annotations

from ctypes import POINTER, c_double, c_uint

import numpy as np

from pipeline.plant.fmu import Instance

double_p = POINTER(c_double)


class References:
    """Value references and a reused buffer: `set` writes an array into the FMU's variables, `get` reads them."""

    def __init__(self, instance: Instance, names: list[str]):
        file = instance.file
        self.n = len(names)
        self.vr = (c_uint * self.n)(*[file.reference(name) for name in names])
        self.buffer = np.zeros(self.n)
        self.pointer = self.buffer.ctypes.data_as(double_p)
        self.component = instance.component
        self._set, self._get = instance.dll.fmi2SetReal, instance.dll.fmi2GetReal

    def set(self, values: np.ndarray) -> int:
        self.buffer[:] = values
        return self._set(self.component, self.vr, self.n, self.pointer)

    def get(self) -> int:
        return self._get(self.component, self.vr, self.n, self.pointer)
