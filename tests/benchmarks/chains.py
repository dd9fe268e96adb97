"""How the filter scales: the compiled EKF of a planar chain of n links (6 n states) against REF of the same chain."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from pipeline.export.build import build
from pipeline.identify.ekf import Tuning
from pipeline.paths import FMUS
from pipeline.plant.binding import Binding
from pipeline.plant.plant import open_plant
from pipeline.plant.steps import floor
from tests.benchmarks.chain import chain_binding
from tests.benchmarks.figure import Figure, at_most, information
from tests.benchmarks.filters import agreements, ekf
from tests.benchmarks.record import Record, prior
from tests.benchmarks.reference import reference
from tests.benchmarks.turns import in_turn, ratio

SIZES, BOUNDED = (2, 4, 8, 16), 16
STEP, SAMPLES, ROUNDS = 1e-3, 400, 15
SIGMA_Q, SIGMA_U, OFF = 1e-4, 0.1, 1e-2


def measure() -> Iterator[Figure]:
    """A ratio for each n, where both filters give the same estimates."""
    build([f"chain{n}" for n in SIZES], FMUS, fmi="2")
    for n in SIZES:
        yield from _figures(n)


def _figures(n: int) -> Iterator[Figure]:
    binding = chain_binding(n, FMUS / f"chain{n}.fmu")
    with reference("chain", LINKS=n) as ref, open_plant(binding, "filter", "ME", "euler", engine="compiled") as plant:
        record = simulated(binding, plant)
        agreement = agreements(ref, plant, record, f"chain, n = {n}")
        yield from agreement
        if not all(figure.held for figure in agreement):
            return
        times = in_turn({"FMU": partial(ekf, plant, record), "REF": partial(ref, record)}, ROUNDS)
    yield information(f"chain, n = {n}: REF, µs a sample", 1e6 * np.median(times["REF"]) / SAMPLES, "µs")
    name, found = f"chain, n = {n}: EKF ÷ dense EKF in C", ratio(times, "FMU", "REF")
    yield at_most(name, found, "REF", 0.9) if n == BOUNDED else information(name, found, "REF")


def simulated(binding: Binding, plant) -> Record:
    """The chain from rest, a sine of its own on each joint, by the filter's steps; noise on inputs and positions."""
    n, rng, t = binding.n, np.random.default_rng(0), STEP * np.arange(SAMPLES)
    u = 2.0 * np.sin(np.outer(t, 2 * np.pi * np.linspace(1.0, 5.0, n)))
    drive = u + SIGMA_U * rng.standard_normal(u.shape)
    states = np.zeros((SAMPLES, 2 * n))
    for k in range(1, SAMPLES):
        states[k] = plant.transition(states[k - 1], drive[k - 1], binding.a_priori, t[k - 1], STEP)
    q = states[:, n:] + SIGMA_Q * rng.standard_normal((SAMPLES, n))
    z0, P0 = prior(binding, q[0], np.full(2 * n, SIGMA_Q**2), OFF)
    tuning = Tuning(np.full(n, SIGMA_Q**2), np.full(n, SIGMA_U**2), input_noise=True)
    return Record(t, q, u, z0, P0, tuning, floor(binding, 2 * n)[: len(z0)])
