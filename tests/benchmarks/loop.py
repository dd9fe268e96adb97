"""The closed loop of two FMUs, 30 s at 100 Hz, against a loop over fmpy's API."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

import numpy as np
import pandas as pd
from fmpy.fmi2 import FMU2Slave

from pipeline.plant.fmu import open_fmu
from pipeline.signals.frames import joint_columns
from pipeline.simulate.closed_loop import controller_inputs, simulate_closed_loop
from pipeline.workflow.acquire import ports_of
from tests.benchmarks.figure import Figure, at_most, information
from tests.benchmarks.fmpy_api import instance, unpacked, user_loop
from tests.benchmarks.record import session
from tests.benchmarks.turns import Spread, in_turn, ratio

DURATION, PERIOD, ROUNDS = 30.0, 0.01, 9
INTERNAL_STEP = {"internalStep": 1e-3}
"""10 sub-steps a sample, as many as the filter by Co-Simulation takes; the FMUs' own would be 40."""


def measure() -> Iterator[Figure]:
    """The ratio, once both loops give the same motion."""
    with loops(INTERNAL_STEP) as (ours, users):
        same = at_most("closed loop − fmpy's API", float(np.max(np.abs(ours() - users()))), "rad, rad/s, N.m", 1e-12)
        yield same
        if not same.held:
            return
        name = "30 s closed loop of two FMUs ÷ a loop over fmpy's API"
        yield at_most(name, _ratio(ours, users), "loop over fmpy's API", 1 / 20)
    with loops({}) as (ours, users):
        yield information(f"{name}, internalStep as built", _ratio(ours, users), "loop over fmpy's API")


def _ratio(ours: Callable, users: Callable) -> Spread:
    return ratio(in_turn({"ours": ours, "API": users}, ROUNDS), "ours", "API")


@contextmanager
def loops(settings: dict[str, float]) -> Iterator[tuple[Callable[[], np.ndarray], Callable[[], np.ndarray]]]:
    """Both loops on unpacked FMUs, each from instantiation to the motion: q, qd, u (N, 6)."""
    s, ports, frame = session(), ports_of(session()), reference()
    plant = {**s.binding.start_values(), **s.binding.filter, **settings}
    controller, inputs, t = dict(s.experiment.controller.start), controller_inputs(ports, frame), frame.index.to_numpy()

    def ours(plant_file, controller_file) -> np.ndarray:
        found = simulate_closed_loop(
            plant_file, controller_file, ports, frame, PERIOD, plant_start=plant, controller_start=controller
        )
        return found[[c for name in ("q_true", "qd_true", "u") for c in joint_columns(name, 2)]].to_numpy()

    def users(plant_file, controller_file) -> np.ndarray:
        with instance(FMU2Slave, *plant_file, plant) as robot, instance(FMU2Slave, *controller_file, controller) as law:
            return user_loop(robot, law, ports, inputs, t, PERIOD)

    paths = s.binding.path, s.controller_fmu
    with open_fmu(paths[0]) as a, open_fmu(paths[1]) as b, unpacked(paths[0]) as c, unpacked(paths[1]) as d:
        yield partial(ours, a, b), partial(users, c, d)


def reference() -> pd.DataFrame:
    """Sines from rest for both joints."""
    t = PERIOD * np.arange(round(DURATION / PERIOD))
    columns = {}
    for i, (size, omega) in enumerate(((1.0, 1.5), (1.5, 3.0)), start=1):
        columns |= {f"qr_{i}": size * (1.0 - np.cos(omega * t)), f"qdr_{i}": size * omega * np.sin(omega * t)}
    return pd.DataFrame(columns, index=pd.Index(t, name="time"))
