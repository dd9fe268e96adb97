"""The closed loop of two FMUs, 30 s at 100 Hz, against a loop over fmpy's API."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
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
from tests.benchmarks.turns import in_turn, ratio

DURATION, PERIOD, ROUNDS = 30.0, 0.01, 9
SUBSTEPS = {
    "10 internal sub-steps of Euler": {"internalStep": 1e-3, "internalOrder": 1},
    "10 internal sub-steps of RK4": {"internalStep": 1e-3},
    "1 internal sub-step of RK4": {"internalStep": 1e-2},
    "40 internal sub-steps of RK4, as built": {},
}
"""What makes so many internal sub-steps of a sample. The first, as many as the filter takes, are asked."""
ASKED = next(iter(SUBSTEPS))


def measure() -> Iterator[Figure]:
    """The ratios, once both loops give the same motion; the start of two FMUs, fmpy's in both, is taken off."""
    for name, steps in SUBSTEPS.items():
        with loops(steps) as (ours, users):
            same = at_most(f"closed loop, {name} − fmpy's API", _apart(ours, users), "rad, rad/s, N.m", 1e-12)
            yield same
            if same.held:
                yield from _ratios(name, ours, users)


def _ratios(name: str, ours: Callable, users: Callable) -> Iterator[Figure]:
    whole = round(DURATION / PERIOD)
    jobs = {f"{who} {N}": partial(loop, N) for N in (2, whole) for who, loop in (("ours", ours), ("API", users))}
    times = in_turn(jobs, ROUNDS)
    loop = {who: times[f"{who} {whole}"] - times[f"{who} 2"] for who in ("ours", "API")}
    title, found = f"30 s closed loop, {name} ÷ fmpy's API", ratio(loop, "ours", "API")
    yield (
        at_most(title, found, "loop over fmpy's API", 1 / 20)
        if name == ASKED
        else information(title, found, "loop over fmpy's API")
    )
    yield information(
        f"{title}, starts included", ratio(times, f"ours {whole}", f"API {whole}"), "loop over fmpy's API"
    )


def _apart(ours: Callable, users: Callable) -> float:
    N = round(DURATION / PERIOD)
    return float(np.max(np.abs(ours(N) - users(N))))


@contextmanager
def loops(steps: Mapping[str, float]) -> Iterator[tuple[Callable[[int], np.ndarray], Callable[[int], np.ndarray]]]:
    """Both loops on unpacked FMUs over N samples, from instantiation to the motion: q, qd, u (N, 6)."""
    s, ports, frame = session(), ports_of(session()), reference()
    plant = {**s.binding.start_values(), **s.binding.filter, **steps}
    controller, inputs, t = dict(s.experiment.controller.start), controller_inputs(ports, frame), frame.index.to_numpy()

    def ours(plant_file, controller_file, N: int) -> np.ndarray:
        starts = {"plant_start": plant, "controller_start": controller}
        found = simulate_closed_loop(plant_file, controller_file, ports, frame[:N], PERIOD, **starts, engine="compiled")
        return found[[c for name in ("q_true", "qd_true", "u") for c in joint_columns(name, 2)]].to_numpy()

    def users(plant_file, controller_file, N: int) -> np.ndarray:
        with instance(FMU2Slave, *plant_file, plant) as robot, instance(FMU2Slave, *controller_file, controller) as law:
            return user_loop(robot, law, ports, inputs, t[:N], PERIOD)

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
