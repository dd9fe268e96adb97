"""A bound plant, opened: its FMU computes the transition over a sample, and by Model Exchange the derivatives.

The state is s = [qd, q], the input u (n,), tau = gain·u, the parameters chi (p,). Each way to compute a transition is
a class with the same face: `n`, `ns`, `calls`, `binding`, `transition(s, u, chi, t, dt)`.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from pipeline.plant.binding import Binding
from pipeline.plant.fmu import Fmu, open_fmu
from pipeline.plant.model_exchange import ModelExchangePlant
from pipeline.plant.restored_state import CoSimulationPlant


@contextmanager
def open_plant(
    binding: Binding,
    use: str = "filter",
    interface: str = "ME",
    method: str = "rk4",
    substeps: int = 4,
    engine: str = "python",
) -> Iterator:
    """Open the bound plant with the binding's values for `use`, "filter", "probe" or "linearise"; freed on leaving.

    interface: "ME", "CS" (each step from a restored FMU state) or "CS reset"; engine: "compiled", or any other for
    Python.
    """
    settings = {"filter": binding.filter, "probe": binding.probe, "linearise": binding.linearise}[use]
    with open_fmu(binding.path) as file, _opened(file, binding, settings, interface, method, substeps) as plant:
        if engine == "compiled":
            from pipeline.plant.compiled import CompiledPlant  # numba is slow to import

            plant = CompiledPlant(plant)
        yield plant


def _opened(file: Fmu, binding: Binding, settings: dict, interface: str, method: str, substeps: int):
    if interface == "ME":
        return ModelExchangePlant(file, binding, settings, method, substeps)
    return CoSimulationPlant(file, binding, settings, "reset" if interface == "CS reset" else "state")
