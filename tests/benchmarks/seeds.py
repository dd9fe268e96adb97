"""Many EKF runs over noise seeds, on two threads and on one: the kernel holds no lock."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from time import perf_counter

import numpy as np

from tests.benchmarks.figure import Figure, at_most, information
from tests.benchmarks.filters import ekf, open_scara
from tests.benchmarks.record import Record, scara
from tests.benchmarks.reference import reference
from tests.benchmarks.turns import in_turn, ratio

SEEDS, BATCHES = 1000, 20
"""A round is a batch of each: a machine that is busy for a while disturbs both."""


def measure() -> Iterator[Figure]:
    """Wall time of 1,000 runs on two threads over that on one; beside it that of REF: what the machine gives now."""
    record, batches = scara(), [range(4), *np.array_split(np.arange(SEEDS), BATCHES)]  # the first to warm up
    with ExitStack() as stack:
        plants = [stack.enter_context(open_scara()) for _ in range(2)]
        ref, pool = stack.enter_context(reference("scara")), stack.enter_context(ThreadPoolExecutor(2))
        filters = {"EKF": [partial(ekf, plant) for plant in plants], "REF": [ref, ref]}
        jobs = {
            f"{name} {threads}": partial(_next_batch, pool, own[:threads], record, iter(batches))
            for name, own in filters.items()
            for threads in (2, 1)
        }
        times = in_turn(jobs, BATCHES, perf_counter)
    yield at_most("1,000 EKF runs, 2 threads ÷ 1, wall time", ratio(times, "EKF 2", "EKF 1"), "one thread", 0.6)
    yield information("1,000 REF runs, 2 threads ÷ 1, wall time", ratio(times, "REF 2", "REF 1"), "one thread")


def _next_batch(pool: ThreadPoolExecutor, filters: Sequence[Callable], record: Record, batches: Iterator) -> None:
    """The next batch of seeds, divided among the filters, a thread each."""
    seeds, n = next(batches), len(filters)
    list(pool.map(run_seeds, filters, [record] * n, [seeds[k::n] for k in range(n)]))


def run_seeds(run: Callable, record: Record, seeds: Sequence[int]) -> np.ndarray:
    """The last estimates (len(seeds), nx): each seed adds its own noise to the record's positions."""
    sigma = np.sqrt(record.tuning.R)
    found = np.empty((len(seeds), len(record.z0)))
    for k, seed in enumerate(seeds):
        noise = sigma * np.random.default_rng(seed).standard_normal(record.q.shape)
        found[k] = run(replace(record, q=record.q + noise)).x[-1]
    return found
