"""The record through which Python and the kernels share a thing: numbers, and addresses of arrays."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pipeline.plant.fmi_kernel import CALLS, DERIVATIVES, FUNCTIONS
from pipeline.plant.fmu import Instance


class Memory:
    """A record of `fields` (see the kernels), `record` (1,), and the arrays that it holds the addresses of."""

    def __init__(self, fields: Sequence[tuple[str, str]]):
        self.record = np.zeros(1, np.dtype(list(fields)))
        self._arrays: dict[str, np.ndarray] = {}

    def set(self, **numbers: float) -> None:
        """Set numbers by field."""
        for name, value in numbers.items():
            self.record[name] = value

    def put(self, **arrays) -> None:
        """Keep arrays, made contiguous, and set each field to its address."""
        for name, array in arrays.items():
            self._arrays[name] = np.ascontiguousarray(array)
            self.record[name] = self._arrays[name].ctypes.data

    def room(self, **shapes: int | tuple[int, ...]) -> None:
        """The same for arrays of zeros of these shapes."""
        self.put(**{name: np.zeros(shape) for name, shape in shapes.items()})

    def __getitem__(self, name: str) -> np.ndarray:
        """An array that is kept."""
        return self._arrays[name]

    def number(self, name: str) -> int:
        """A number by its field."""
        return int(self.record[name][0])


def connect(memory: Memory, instance: Instance) -> None:
    """Fill in the fields of an instance: its functions' addresses and its handle."""
    calls = instance.calls
    memory.set(**{name: calls.address(name) for name in FUNCTIONS})
    memory.set(fmu=calls.instance, fmi3=calls.prefix == "fmi3")
    memory.room(flags=4)


def refuse(memory: Memory, instance: Instance, t: float) -> None:
    """Raise FmuError for what a kernel failed with at t (s)."""
    call = CALLS[memory.number("call")]
    if call == CALLS[DERIVATIVES]:
        call = instance.calls.derivatives_call.removeprefix(instance.calls.prefix)
    instance.check(memory.number("status"), call, t)
