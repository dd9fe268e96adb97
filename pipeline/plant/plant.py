"""A bound plant, opened: its FMU computes the transition over a sample, and by Model Exchange the derivatives.

The state is s = [qd, q], the input u (n,), tau = gain·u, the parameters chi (p,). Each way to compute a transition is
a class with the same face: `n`, `ns`, `calls`, `binding`, `transition(s, u, chi, t, dt)`.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from pipeline.plant.binding import Binding
from pipeline.plant.fmu import open_fmu
from pipeline.plant.model_exchange import ModelExchangePlant
from pipeline.plant.restored_state import CoSimulationPlant


@contextmanager
def open_plant(
    binding: Binding,
    use: str = "filter",
    interface: str = "ME",
    method: str = "rk4",
    substeps: int = 4,
) -> Iterator[ModelExchangePlant | CoSimulationPlant]:
    """Open the bound plant with the binding's values for `use`, "filter", "probe" or "linearise"; freed on leaving."""
    kind = {"ME": ModelExchangePlant, "CS": CoSimulationPlant}[interface]
    settings = {"filter": binding.filter, "probe": binding.probe, "linearise": binding.linearise}[use]
    with open_fmu(binding.path) as file, kind(file, binding, settings, method, substeps) as plant:
        yield plant
