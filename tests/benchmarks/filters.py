"""The compiled EKF through the SCARA's FMU: against REF, by interface, FMI version and form of the covariance."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from functools import partial

import numpy as np
from fmpy.fmi2 import FMU2Model
from msgspec import structs

from pipeline.identify.ekf import run_filter
from pipeline.plant.binding import Binding
from pipeline.plant.plant import open_plant
from pipeline.records import FilterRun
from tests.benchmarks.figure import Figure, at_least, at_most, information
from tests.benchmarks.fmpy_api import UserPlant, instance, unpacked, user_ekf
from tests.benchmarks.record import Record, scara, session
from tests.benchmarks.reference import Reference, reference
from tests.benchmarks.turns import in_turn, ratio

AGREED = {"forward": 1e-7, "central": 1e-9}
ROUNDS, SLOW_ROUNDS, REPEATED = 101, 5, 10


def measure() -> Iterator[Figure]:
    """The figures of the filter; ratios only where REF's estimates are the filter's."""
    record = scara()
    with reference("scara") as ref, opened() as plants:
        agreement = [*agreements(ref, plants["ME"], record), _users_agreement(record, ref)]
        yield from agreement
        if all(figure.held for figure in agreement):
            yield from _ratios(record, ref, plants)
            yield _against_the_api(record, plants["ME"])


@contextmanager
def opened() -> Iterator[dict]:
    """The SCARA opened in every way that is measured."""
    ways = {"ME": ("ME", "2"), "FMI 3.0": ("ME", "3")}
    ways |= {"CS": ("CS", "2", 1), "CS, RK4": ("CS", "2", 4), "CS reset": ("CS reset", "2", 1)}
    with ExitStack() as stack:
        yield {name: stack.enter_context(open_scara(*way)) for name, way in ways.items()}


def open_scara(interface: str = "ME", fmi: str = "2", order: int = 1, engine: str = "compiled"):
    """The SCARA for the filter: Euler's steps by Model Exchange, 10 internal sub-steps a sample by Co-Simulation.

    order: of these sub-steps, 1 (Euler) or 4 (Runge-Kutta).
    """
    binding = session(fmi).binding
    if interface != "ME":
        binding = structs.replace(binding, set={**binding.set, "internalStep": 1e-3, "internalOrder": order})
    return open_plant(binding, "filter", interface, "euler", engine=engine)


def ekf(plant, record: Record, jacobian: str = "forward", covariance: str = "joseph") -> FilterRun:
    """The filter on a record; RuntimeError where it fails."""
    r = record
    run = run_filter(plant, r.time, r.q, r.u, r.z0, r.P0, r.tuning, jacobian, covariance)
    if run.failed_at is not None:
        raise RuntimeError(f"the filter stopped at sample {run.failed_at}: {run.reason}")
    return run


def apart(x: np.ndarray, other: np.ndarray, record: Record) -> float:
    """How far the estimates (N, nx) of two filters are apart, anywhere on the record, relative to their sizes."""
    return float(np.max(np.abs(x - other) / np.maximum(np.abs(other), record.scale)))


def agreements(ref: Reference, plant, record: Record, name: str = "EKF (ME)") -> list[Figure]:
    """The filter against REF with both kinds of differences."""
    return [
        at_most(
            f"{name} − REF, {mode} differences",
            apart(ekf(plant, record, mode).x, ref(record, mode).x, record),
            "relative",
            bound,
        )
        for mode, bound in AGREED.items()
    ]


def _ratios(record: Record, ref: Reference, plants: Mapping) -> Iterator[Figure]:
    ways = ("CS", "CS, RK4", "CS reset", "ME", "FMI 3.0")  # so that neither version finds its own FMU in the caches
    jobs = {"REF": partial(ref, record), "UDU": partial(ekf, plants["ME"], record, covariance="udu")}
    jobs |= {name: partial(ekf, plants[name], record) for name in ways}
    times = in_turn(jobs, ROUNDS)
    microseconds = 1e6 * np.median(times["REF"]) / len(record.time)
    yield information("REF, µs a sample", microseconds, "µs")
    yield at_most("EKF through the ME FMU ÷ REF", ratio(times, "ME", "REF"), "REF", 0.9)
    yield at_most("EKF, FMI 3.0 ÷ FMI 2.0", ratio(times, "FMI 3.0", "ME"), "FMI 2.0", 1.05)
    yield at_most("EKF by CS, set-state, 10 internal sub-steps of Euler ÷ REF", ratio(times, "CS", "REF"), "REF", 4.0)
    yield information("EKF by CS, reset, 10 internal sub-steps of Euler ÷ REF", ratio(times, "CS reset", "REF"), "REF")
    yield information("EKF by CS, set-state, 10 internal sub-steps of RK4 ÷ REF", ratio(times, "CS, RK4", "REF"), "REF")
    yield at_most("EKF, UDUᵀ ÷ Joseph", ratio(times, "UDU", "ME"), "Joseph", 1.4)


def _against_the_api(record: Record, plant) -> Figure:
    """A slow run leaves the caches cold, so the filter runs REPEATED times in its turn."""

    def repeated() -> None:
        for _ in range(REPEATED):
            ekf(plant, record)

    with _users_filter(record) as users:
        times = in_turn({"API": users, "compiled": repeated}, SLOW_ROUNDS)
    times["compiled"] /= REPEATED
    return at_least("fmpy's API + filterpy ÷ compiled EKF", ratio(times, "API", "compiled"), "compiled EKF", 150.0)


def _users_agreement(record: Record, ref: Reference) -> Figure:
    with _users_filter(record) as users:
        difference = apart(users(), ref(record).x, record)
    return at_most("fmpy's API + filterpy − REF, forward differences", difference, "relative", AGREED["forward"])


@contextmanager
def _users_filter(record: Record) -> Iterator[Callable[[], np.ndarray]]:
    binding: Binding = session().binding
    start = {**binding.start_values(), **binding.filter}
    with unpacked(binding.path) as (description, folder), instance(FMU2Model, description, folder, start) as opened_fmu:
        yield partial(user_ekf, UserPlant(*opened_fmu, binding), record, binding.u_range)
