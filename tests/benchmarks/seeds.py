"""Many EKF runs over noise seeds, on two threads and on one: the kernel holds no lock."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import replace
from time import perf_counter

import numpy as np

from tests.benchmarks.figure import Figure, at_most
from tests.benchmarks.filters import ekf, open_scara
from tests.benchmarks.record import Record, scara
from tests.benchmarks.turns import in_turn, ratio

SEEDS, BATCHES = 1000, 20
"""A round is a batch of each: a machine that is busy for a while disturbs both."""


def measure() -> Iterator[Figure]:
    """Wall time of 1,000 runs on two threads over that on one."""
    record = scara()
    batches = [range(4), *np.array_split(np.arange(SEEDS), BATCHES)]  # the first to warm up
    turns = iter([batch for batch in batches for _ in range(2)])
    with ExitStack() as stack:
        plants = [stack.enter_context(open_scara()) for _ in range(2)]
        pool = stack.enter_context(ThreadPoolExecutor(2))

        def on(threads: int) -> None:
            seeds = next(turns)
            shares = [seeds[k::threads] for k in range(threads)]
            list(pool.map(run_seeds, plants, [record] * threads, shares))

        times = in_turn({"two": lambda: on(2), "one": lambda: on(1)}, BATCHES, perf_counter)
    yield at_most("1,000 EKF runs, 2 threads ÷ 1, wall time", ratio(times, "two", "one"), "one thread", 0.6)


def run_seeds(plant, record: Record, seeds: Sequence[int]) -> np.ndarray:
    """The last estimates (len(seeds), nx): each seed adds its own noise to the record's positions."""
    sigma = np.sqrt(record.tuning.R)
    found = np.empty((len(seeds), len(record.z0)))
    for k, seed in enumerate(seeds):
        noise = sigma * np.random.default_rng(seed).standard_normal(record.q.shape)
        found[k] = ekf(plant, replace(record, q=record.q + noise)).x[-1]
    return found
