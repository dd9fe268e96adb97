"""The loops of `coupling.py` on their kernels: the same arguments, results and errors."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pipeline.interrupts import raise_kept
from pipeline.plant.compiled_slave import CompiledSlave, compiled_port
from pipeline.plant.cosimulation import Port
from pipeline.plant.memory import Memory
from pipeline.simulate import coupling_kernel
from pipeline.simulate.coupling_kernel import DONE, FOLLOWED, LOOP
from pipeline.simulate.sensors import Noise

CHUNK = 100
"""Samples at a time: between them an interrupt is seen."""


def couple(
    states: Port, sensed: Port, output: Port, drive: Port, t: np.ndarray, dt: float, inputs: np.ndarray, noise: Noise
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """`coupling.couple`, compiled."""
    (N, m), n, in_loop = inputs.shape, len(drive.names), noise.loop == "disturbed"
    memory = Memory(LOOP)
    memory.set(n=n, m=m, disturbed=in_loop, dt=dt)
    memory.put(t=t, inputs=inputs, quantum=np.zeros(n) if noise.quantum is None else _doubles(noise.quantum))
    memory.put(position_noise=_doubles(noise.position), input_noise=_doubles(float(in_loop) * noise.input))
    memory.put(state=np.empty((N, 2 * n)), q=np.empty((N, n)), u=np.empty((N, n)))
    robot, law = CompiledSlave(states.slave), CompiledSlave(sensed.slave)
    parts = robot.memory, law.memory, *map(compiled_port, (states, sensed, output, drive)), memory
    where = _run(coupling_kernel.couple, parts, N)
    if where != DONE:
        slave, port, writing = (
            (robot, states, False), (law, sensed, True), (law, None, True),
            (law, output, False), (robot, drive, True), (robot, None, True),
        )[where]  # fmt: skip
        slave.refuse(port, writing)
    return memory["state"], memory["q"], memory["u"]


def follow(
    before: Port, inlet: Port, after: Port, t: np.ndarray, dt: float, inputs: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """`coupling.follow`, compiled."""
    N, n_before, n_inlet, n_after = len(t), *(len(port.names) for port in (before, inlet, after))
    memory = Memory(FOLLOWED)
    memory.set(n_before=n_before, n_inlet=n_inlet, n_after=n_after, dt=dt)
    memory.put(t=t, inputs=inputs, before=np.empty((N, n_before)), after=np.empty((N, n_after)))
    slave = CompiledSlave(inlet.slave)
    where = _run(coupling_kernel.follow, (slave.memory, *map(compiled_port, (before, inlet, after)), memory), N)
    if where != DONE:
        slave.refuse(*((before, False), (inlet, True), (None, True), (after, False))[where])
    return memory["before"], memory["after"]


def _run(kernel: Callable, parts: tuple[Memory, ...], N: int) -> int:
    """Run N samples in chunks; where it failed, or DONE."""
    records = [part.record for part in parts]
    for first in range(0, N, CHUNK):
        where = kernel(*records, first, min(first + CHUNK, N))
        raise_kept()
        if where != DONE:
            return where
    return DONE


def _doubles(values) -> np.ndarray:
    return np.ascontiguousarray(values, dtype=float)
