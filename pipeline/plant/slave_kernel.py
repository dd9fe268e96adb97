"""A Co-Simulation slave and its ports in compiled code: what `cosimulation.py` does, without Python."""

from __future__ import annotations

from math import isfinite

from pipeline.plant.fmi_kernel import INPUTS, INSTANCE, OUTPUTS, do_step, failed, get_values, set_values
from pipeline.plant.fmu import NOT_FINITE
from pipeline.plant.kernel import array_at, kernel

SLAVE = [*INSTANCE, ("t", "f8")]
"""Fields of the record of a slave; t: its communication point (s)."""

PORT = [(name, "i8") for name in ("n", "references", "values")]
"""Fields of the record of a port: the number of its variables, and the addresses of their references and values."""


@kernel
def _finite(port):
    values = array_at(port.values, port.n)
    for i in range(port.n):
        if not isfinite(values[i]):
            return False
    return True


@kernel
def write(slave, port):
    """Set the port's variables to its values; what is not finite is refused before the FMU sees it."""
    if not _finite(port):
        return failed(slave, INPUTS, NOT_FINITE)
    return set_values(slave, INPUTS, port.references, port.n, port.values)


@kernel
def read(slave, port):
    """Read the port's variables into its values."""
    if get_values(slave, OUTPUTS, port.references, port.n, port.values):
        return True
    return False if _finite(port) else failed(slave, OUTPUTS, NOT_FINITE)


@kernel
def step(slave, t, dt):
    """Advance from the communication point t to t + dt (s)."""
    slave.t = t
    if do_step(slave, t, dt):
        return True
    slave.t = t + dt
    return False
