"""The record through which Python and the kernels share a thing: numbers, and addresses of arrays."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.plant.fmi_kernel import CALLS, DERIVATIVES, FUNCTIONS
from pipeline.plant.fmu import Instance


class Memory:
    """A record of `fields` (see the kernels), `record` (1,): numbers, arrays within it, and addresses of others."""

    def __init__(self, fields: Sequence[tuple]):
        self.record = np.zeros(1, np.dtype(list(fields)))
        self._kept: dict[str, np.ndarray] = {}

    def set(self, **values) -> None:
        """Set numbers, and arrays within the record, by field."""
        for name, value in values.items():
            self.record[name][0] = value

    def put(self, **arrays) -> None:
        """Keep arrays, made contiguous, and set each field to its address."""
        for name, array in arrays.items():
            self._kept[name] = np.ascontiguousarray(array)
            self.record[name] = self._kept[name].ctypes.data

    def room(self, **shapes: int | tuple[int, ...]) -> None:
        """The same for arrays of zeros of these shapes."""
        self.put(**{name: np.zeros(shape) for name, shape in shapes.items()})

    def __getitem__(self, name: str) -> np.ndarray | int | float:
        """An array that is kept, or the field's own."""
        return self._kept[name] if name in self._kept else self.record[name][0]


def connect(memory: Memory, instance: Instance) -> None:
    """Fill in the fields of an instance: its functions' addresses and its handle."""
    calls = instance.calls
    memory.set(**{name: calls.address(name) for name in FUNCTIONS})
    memory.set(fmu=calls.instance, fmi3=calls.prefix == "fmi3")
    memory.put(flags=np.zeros(4))


def refuse(memory: Memory, instance: Instance, t: float) -> None:
    """Raise FmuError for what a kernel failed with at t (s)."""
    call = CALLS[memory["call"]]
    if call == CALLS[DERIVATIVES]:
        call = instance.calls.derivatives_call.removeprefix(instance.calls.prefix)
    instance.check(int(memory["status"]), call, t)
