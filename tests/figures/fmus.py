"""The figures of the exported FMUs: accuracy against SciPy's Radau, replay of the FMU state."""

from __future__ import annotations

import numpy as np

from pipeline.export.build import build
from pipeline.paths import FMUS
from pipeline.plant.binding import gains_of_bindings, variants_of_bindings
from tests.export.driver import Archive
from tests.export.oracles import march
from tests.export.test_fmus import PLANTS, H, by_model_exchange, commands, drive
from tests.figures import versions
from tests.figures.figure import Figure, at_most, yes


def measure() -> list[Figure]:
    """Every figure of the FMUs."""
    build(None, FMUS, gains_of_bindings(), variants=variants_of_bindings())
    rows = versions.measure()
    for name in PLANTS:
        archive = Archive(FMUS / f"{name}.fmu")
        try:
            rows += [*_accuracy(archive, name), _replay(archive, name)]
        finally:
            archive.close()
    return rows


def _accuracy(archive: Archive, name: str) -> list[Figure]:
    """Co-Simulation at 0.25 ms and Model Exchange against Radau at 1e-10, through friction reversals."""
    rhs, values, inputs, outputs = PLANTS[name]
    rows = []
    for kind in ("smooth", "rough"):
        exact = march(rhs(values), np.zeros(len(outputs)), commands(name, kind), H)
        with archive.co_simulation(**values, internalStep=2.5e-4) as instance:
            error = np.abs(drive(instance, name, commands(name, kind)) - exact)
        n = len(inputs)
        for what, columns in (("position", slice(None, n)), ("velocity", slice(n, None))):
            title = f"{name}: Co-Simulation, {kind} reversals, {what}, at 0.25 ms"
            rows.append(at_most(title, float(error[:, columns].max()), 1e-8))
    found = by_model_exchange(archive, name)
    return [*rows, at_most(f"{name}: Model Exchange, rough reversals", float(np.abs(found - exact).max()), 1e-7)]


def _replay(archive: Archive, name: str) -> Figure:
    """The same steps from a restored FMU state, bit for bit."""
    u, half = commands(name, "rough"), 50
    with archive.co_simulation(**PLANTS[name][1]) as instance:
        drive(instance, name, u[:half])
        state = instance.fmu.getFMUstate()
        runs = []
        for _ in range(2):
            instance.fmu.setFMUstate(state)
            runs.append(_continue(instance, name, u, half))
        instance.fmu.freeFMUstate(state)
    same = np.array_equal(*runs)
    return yes(f"{name}: FMU state replays", same, "bit for bit" if same else "differs", "bit for bit")


def _continue(instance, name: str, u: np.ndarray, first: int) -> np.ndarray:
    inputs, outputs = PLANTS[name][2:]
    rows = []
    for k in range(first, len(u)):
        instance.set(**dict(zip(inputs, u[k], strict=True)))
        instance.step(k * H, H)
        rows.append(instance.get(*outputs))
    return np.array(rows)
