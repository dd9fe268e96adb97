"""The regressor probed from the FMU, against the closed form in NumPy."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from pipeline.plant.plant import open_plant
from pipeline.plant.probing import probe
from tests.benchmarks.figure import Figure, at_most
from tests.benchmarks.record import session
from tests.benchmarks.turns import in_turn, ratio

SAMPLES, ROUNDS = 2500, 101


def measure() -> Iterator[Figure]:
    """The ratio, once both give the same regressor."""
    rng = np.random.default_rng(0)
    motion = [rng.uniform(-size, size, (SAMPLES, 2)) for size in (2.4, 6.0, 30.0)]
    with open_plant(session().binding, "probe", engine="compiled") as plant:
        model = probe(plant, *motion)
        D, exact = model(*motion)[0], closed_form(*motion)
        same = at_most("regressor − closed form", np.max(np.abs(D - exact)) / np.max(np.abs(exact)), "of max|D|", 1e-9)
        yield same
        if same.held:
            times = in_turn({"FMU": partial(model, *motion), "closed form": partial(closed_form, *motion)}, ROUNDS)
            name = "regressor from the FMU ÷ closed form, 2,500 samples"
            yield at_most(name, ratio(times, "FMU", "closed form"), "closed form in NumPy", 30.0)


def closed_form(q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
    """D (N, 2, 8) of tests/closed_form.py, every term computed once and written where it belongs."""
    (qd1, qd2), (qdd1, qdd2) = qd.T, qdd.T
    C2, S2 = np.cos(q[:, 1]), np.sin(q[:, 1])
    both, centrifugal = qdd1 + qdd2, qd1 * qd1
    swing, coriolis = qdd1 + both, qd2 * (2 * qd1 + qd2)
    D = np.zeros((len(q), 2, 8))
    D[:, 0, 0], D[:, 0, 1], D[:, 0, 2] = qdd1, qd1, np.sign(qd1)
    D[:, 0, 3] = D[:, 1, 3] = both
    D[:, 0, 4] = swing * C2 - coriolis * S2
    D[:, 0, 5] = -swing * S2 - coriolis * C2
    D[:, 1, 4] = qdd1 * C2 + centrifugal * S2
    D[:, 1, 5] = centrifugal * C2 - qdd1 * S2
    D[:, 1, 6], D[:, 1, 7] = qd2, np.sign(qd2)
    return D
