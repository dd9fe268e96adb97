"""Both engines: every estimate of the experiments, compiled against Python."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pipeline.workflow.run import identify
from pipeline.workflow.session import open_session
from tests.figures.figure import Figure, at_most

ASKED = {"central": 1e-9, "forward": 1e-7, "directional": 1e-7}
"""Relative; of directional derivatives, the columns of parameters are forward differences."""


def measure() -> Iterator[Figure]:
    """The largest relative difference of any value or sigma, by experiment and mode of the Jacobian."""
    for experiment in ("scara", "emps"):
        for mode, limit in ASKED.items():
            python, compiled = (_numbers(experiment, mode, engine) for engine in ("python", "compiled"))
            name = f"{experiment}, {mode}: {len(python)} values and sigmas, compiled − Python"
            yield at_most(name, _apart(python, compiled), limit)


def _numbers(experiment: str, mode: str, engine: str) -> dict[tuple[str, str, str], float | None]:
    """Value and sigma of every parameter of every estimate, simulated data."""
    overrides = [f"ekf.jacobian={mode!r}", f"engine={engine!r}"]
    record, _ = identify(open_session(experiment, overrides, simulated=True))
    if record["errors"]:
        raise RuntimeError(record["errors"][0]["message"])
    return {
        (name, parameter, key): found[key]
        for name, estimate in record["estimates"].items()
        for parameter, found in estimate["parameters"].items()
        for key in ("value", "sigma")
    }


def _apart(one: dict, other: dict) -> float:
    """inf where an estimate or its sigma is missing in one of them only."""
    if {k for k, v in one.items() if v is None} != {k for k, v in other.items() if v is None}:
        return np.inf
    pairs = [(v, other[k]) for k, v in one.items() if v is not None]
    return max(abs(a - b) / abs(b) if a != b else 0.0 for a, b in pairs)
