"""A Co-Simulation slave and its ports for kernels: their records, and the error for what a kernel failed with."""

from __future__ import annotations

from pipeline.plant.cosimulation import Port, Slave
from pipeline.plant.memory import Memory, connect
from pipeline.plant.slave_kernel import PORT, SLAVE


class CompiledSlave:
    """A slave's record; the slave must live as long."""

    def __init__(self, slave: Slave):
        self._slave, self.memory = slave, Memory(SLAVE)
        connect(self.memory, slave.instance)
        self.memory.set(t=slave.t)

    def refuse(self, port: Port | None, writing: bool) -> None:
        """Raise FmuError for what a kernel failed with: writing or reading a port, or without one a step."""
        self._slave.t, status = float(self.memory["t"]), int(self.memory["status"])
        if port is None:
            self._slave.check(status)
        else:
            port.check(status, writing)


def compiled_port(port: Port) -> Memory:
    """A port's record; the port, whose own values a kernel reads and writes, must live as long."""
    memory = Memory(PORT)
    memory.set(n=len(port.names))
    memory.put(references=port.references, values=port.values)
    return memory
